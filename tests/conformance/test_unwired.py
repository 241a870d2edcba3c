"""A controller whose measurements are not wired says so, in both flavours; and what some importers do is no mistake."""
from ctypes import c_double, c_int

import pytest

from cosim.errors import RunError
from cosim.master.fmu import FmuFile
from cosim.master.instance import Instance
from cosim.vehicle.closed_loop import fmu_path
from cosim.vehicle.registry import LAWS

ZEROS = dict.fromkeys(("V", "h", "gamma", "theta", "Q", "V_command", "h_command"), 0.0)


@pytest.fixture(params=[(flavour, law) for flavour in ("native", "python") for law in LAWS], ids="-".join)
def controller(request, native_fmus, python_fmus):
    flavour, law = request.param
    with FmuFile.open(fmu_path(flavour, LAWS[law].fmu)) as file:
        instance = Instance(file, "controller")
        try:
            instance.setup(0.0, 1.0)
            instance.simple("fmi2EnterInitializationMode")
            yield instance
        finally:
            instance.close()


@pytest.mark.parametrize("values, said", [
    (ZEROS, "V = 0 ft/s: is it wired? It starts with V from 4000 to 16000 ft/s, set before initialisation ends"),
    ({"h": 0.0}, "h = 0 ft: is it wired? It starts with h from 40000 to 160000 ft, set before initialisation ends"),
    ({"V": 7.7}, "V = 7.7 ft/s: is it wired?"), ({"V": 1e6}, "V = 1e+06 ft/s: is it wired?"),
], ids=["all zero", "h alone", "km/s", "too fast"])
def test_a_measurement_that_is_not_wired_is_named(controller, values, said):
    controller.set(values)
    with pytest.raises(RunError) as error:
        controller.simple("fmi2ExitInitializationMode")
    assert f"cannot start: {said}" in str(error.value)


def test_a_measurement_that_is_lost_on_the_way_is_named(controller):
    controller.simple("fmi2ExitInitializationMode")
    controller.set({"V": 0.0})
    with pytest.raises(RunError) as error:
        controller.check(controller.call("fmi2DoStep", c_double(0.0), c_double(0.01), c_int(1)), "fmi2DoStep")
    assert "V = 0 ft/s: is it wired? " in str(error.value) and "at t = 0.01 s" in str(error.value)


def test_zeros_that_are_replaced_before_initialisation_ends_are_forgotten(controller):
    controller.set(ZEROS)
    controller.set({"V": 7700.0, "h": 85000.0, "V_command": 7700.0, "h_command": 85000.0})
    controller.simple("fmi2ExitInitializationMode")
    assert controller.get(["V_reference"]) == [7700.0]
