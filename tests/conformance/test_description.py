"""What every FMU of ours says of itself in modelDescription.xml and beside it, in both flavours."""
import re
import tomllib
import zipfile
from importlib.metadata import version
from pathlib import Path

import pint
import pytest
from lxml import etree

from cosim.errors import RunError
from cosim.master.fmu import FmuFile
from cosim.master.instance import Instance
from cosim.master.quantities import BASE
from cosim.vehicle.registry import LAWS, MODELS

ROOT = Path(__file__).parents[2]


@pytest.fixture(params=["native_fmus", "python_fmus"])
def fmus(request) -> dict[str, Path]:
    return request.getfixturevalue(request.param)


@pytest.mark.parametrize("name", MODELS)
def test_author_copyright_and_licence_travel_with_the_fmu(fmus, name):
    with zipfile.ZipFile(fmus[name]) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
        licence = archive.read("documentation/licenses/license.txt")
        carried = [path for path in archive.namelist() if path.startswith("resources/pythonfmu/")]
        if carried:
            assert b"MIT License" in archive.read("documentation/licenses/pythonfmu.txt")
    assert root.get("author") == "the AHV FMU authors"
    assert root.get("copyright") == "Copyright 2026 the AHV FMU authors"
    assert root.get("license") == "BSD-2-Clause"
    assert licence == (ROOT / "LICENSE").read_bytes() and b"Copyright (c) 2026, the AHV FMU authors" in licence


@pytest.mark.parametrize("name", MODELS)
def test_ports_are_reals_so_that_tools_without_booleans_fly_the_fmu(fmus, name):
    with FmuFile.open(fmus[name]) as file:
        ports = [v for v in file.description.variables if v.causality in ("input", "output")]
    assert ports and {v.type for v in ports} == {"Real"}
    flags = [v for v in ports if v.variability == "discrete"]
    assert all((v.unit, v.min, v.max) == ("1", 0.0, 1.0) for v in flags)
    if name in {law.fmu for law in LAWS.values()}:
        assert {"fuel_ratio_saturated", "elevator_saturated"} <= {v.name for v in flags}


@pytest.mark.parametrize("name", MODELS)
def test_pint_reads_every_unit_and_converts_as_the_fmu_says(fmus, name):
    quantity = pint.UnitRegistry().Quantity
    with FmuFile.open(fmus[name]) as file:
        units = file.description.units
        unknown = {v.unit for v in file.description.variables} - set(units) - {""}
    assert units and not unknown
    for unit in units.values():
        base = "*".join(f"{part}^{n}" for part, n in zip(BASE, unit.exponents) if n) or "1"
        assert quantity(1, unit.name).to(base).magnitude == pytest.approx(unit.factor, rel=1e-9), unit.name
        for shown in unit.displays:
            assert quantity(1, unit.name).to(shown.name).magnitude == pytest.approx(shown.factor, rel=1e-9), shown


def test_an_fmu_names_what_made_it_with_versions(native_fmus, python_fmus):
    made_by = {"native": native_fmus, "python": python_fmus}
    tools = {}
    for flavour, fmus in made_by.items():
        with FmuFile.open(fmus["AhvPlant"]) as file:
            tools[flavour] = file.description.attributes["generationTool"]
    assert tools == {"native": f"ahv {version('ahv')}, casadi {version('casadi')}, ziglang {version('ziglang')}",
                     "python": f"ahv {version('ahv')}, casadi {version('casadi')}, pythonfmu {version('pythonfmu')}"}


def test_what_decides_on_an_fmus_bytes_is_pinned_exactly_and_as_the_locks_have_it():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needed = [*project["dependencies"], *project["optional-dependencies"]["native"]]
    for name in ("casadi", "ziglang", "pythonfmu"):
        pin, = (line for line in needed if line.startswith(name))
        assert re.fullmatch(rf"{name}==[\d.]+", pin)
        assert pin in (ROOT / "requirements" / "all.txt").read_text().split()


@pytest.mark.parametrize("variable, told", [("reference_omega", "1000 rad/s is above its maximum 100 rad/s"),
                                            ("elevator_max", "57295.8 deg is above its maximum 90 deg")])
def test_a_refusal_gives_a_frequency_in_radians_per_second_and_an_angle_in_degrees(fmus, variable, told):
    file = FmuFile.open(fmus["AhvController"])
    instance = Instance(file, "controller")
    try:
        with pytest.raises(RunError, match=f"{variable} = {told}"):
            instance.set({variable: 1000.0})
    finally:
        instance.close()
        file.close()
