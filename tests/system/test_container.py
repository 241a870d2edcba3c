"""A system as one FMU: flown by FMPy it is the flight of our master with the algorithm jacobi."""
import zipfile

import fmpy
import numpy as np
import pytest
import ssp_files as s
from command import carried_out

import cosim
from cosim.errors import UsageError
from cosim.ssp.container import write_container
from cosim.ssp.load import load_ssp
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop

STEP = 0.01
TOLERANCE = 1e-9   # of a signal's nominal value


def container(*words):
    return carried_out("container", *words)


def flown(path, stop, names, step=STEP, **more):
    return fmpy.simulate_fmu(str(path), stop_time=stop, step_size=step, output_interval=step, output=names,
                             fmi_type="CoSimulation", **more)


def differences(path, result, flight, names):
    """The largest difference of each signal, as a part of its nominal value."""
    nominal = {v.name: abs(float(v.nominal or 1.0)) for v in fmpy.read_model_description(str(path)).modelVariables}
    assert len(result) == len(flight.time)
    return {n: np.abs(result[n] - flight[n]).max() / nominal[n] for n in names}


def case1(**values):
    return closed_loop(scenarios.load("case1"), values=values).system


@pytest.mark.parametrize("flavour,stop", [("native", 30.0), ("python", 2.0)])
def test_fmpy_flies_the_loop_as_our_master_does(flavour, stop, native_fmus, python_fmus, tmp_path):
    done = container("case1", "--flavour", flavour, "--out", tmp_path / "Loop.fmu")
    assert done.returncode == 0, done.stderr
    system = closed_loop(scenarios.load("case1"), flavour=flavour).system
    flight = cosim.fly(system, STEP, stop, algorithm="jacobi", progress=False)
    names = list(flight)
    assert len(names) > 30
    found = differences(tmp_path / "Loop.fmu", flown(tmp_path / "Loop.fmu", stop, names), flight, names)
    worst = max(found, key=found.get)
    print(f"\n{flavour}: {len(names)} signals, the largest difference is {found[worst]:.1e} ({worst})")
    assert found[worst] <= TOLERANCE, worst


def test_parameters_are_reached_by_component_and_name(native_fmus, tmp_path):
    path = tmp_path / "Loop.fmu"
    write_container(path, "case1", case1(), STEP, 100)
    start = {"plant.mass": 310.0, "controller.kV1": 4.0, "plant.start_at_trim": False, "plant.theta_start": 0.03}
    result = flown(path, 2, ["plant.V", "plant.h", "plant.mass"], start_values=start)
    values = {"plant": {"mass": 310.0, "start_at_trim": False, "theta_start": 0.03}, "controller": {"kV1": 4.0}}
    flight = cosim.fly(case1(**values), STEP, 2.0, algorithm="jacobi", progress=False)
    assert max(differences(path, result, flight, ["plant.V", "plant.h"]).values()) <= TOLERANCE
    assert (result["plant.mass"] == 310.0).all()
    other = flown(path, 2, ["plant.V"])
    assert np.abs(other["plant.V"] - flight["plant.V"]).max() > 1e-3


def test_values_of_the_system_are_the_containers_start_values(native_fmus, tmp_path):
    path = tmp_path / "Heavy.fmu"
    write_container(path, "heavy", case1(plant={"mass": 310.0}), STEP, 100)
    variables = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    assert float(variables["plant.mass"].start) == 310.0 and variables["plant.mass"].unit == "slug/ft"
    flight = cosim.fly(case1(plant={"mass": 310.0}), STEP, 1.0, algorithm="jacobi", progress=False)
    assert max(differences(path, flown(path, 1, ["plant.h"]), flight, ["plant.h"]).values()) <= TOLERANCE


def test_a_named_input_takes_the_place_of_what_feeds_it(native_fmus, tmp_path):
    path = tmp_path / "Commanded.fmu"
    done = container("hold", "--out", path, "--connector", "V_command=controller.V_command", "--connector", "plant.*",
                     "--connector", "elevator=controller.elevator")
    assert done.returncode == 0, done.stderr
    assert "controller.V_command is an input of the FMU now; scenario.V_command fed it." in done.stderr
    ports = {v.name: v.causality for v in fmpy.read_model_description(str(path)).modelVariables
             if v.causality in ("input", "output")}
    assert [n for n, causality in ports.items() if causality == "input"] == ["V_command"]
    assert {n for n in ports if "." not in n} == {"V_command", "elevator"}
    assert {n.partition(".")[0] for n in ports if "." in n} == {"plant"}

    result = flown(path, 2, ["plant.V", "elevator"], start_values={"V_command": 7750.0})
    loop = closed_loop(scenarios.load("hold")).system
    apart = cosim.System([c.with_values({"V_command": 7750.0}) if c.name == "controller" else c
                          for c in loop.components],
                         [link for link in loop.connections if link.target != "controller.V_command"])
    flight = cosim.fly(apart, STEP, 2.0, algorithm="jacobi", progress=False)
    assert np.abs(result["plant.V"] - flight["plant.V"]).max() <= 1e-9 * 1000
    assert np.abs(result["elevator"] - flight["controller.elevator"]).max() <= 1e-9 * 0.1


def test_an_ssp_becomes_one_fmu_that_flies_the_same(native_fmus, tmp_path):
    done = carried_out("ssp", "case1", "--out", tmp_path / "case1.ssp")
    assert done.returncode == 0, done.stderr
    done = container(tmp_path / "case1.ssp", "--set", "plant.mass=310", "--out", tmp_path / "Ssp.fmu")
    assert done.returncode == 0, done.stderr
    write_container(tmp_path / "Loop.fmu", "case1", case1(plant={"mass": 310.0}), STEP, 100)
    names = ["plant.V", "plant.h", "controller.elevator"]
    one, other = (flown(tmp_path / f"{name}.fmu", 1, names) for name in ("Ssp", "Loop"))
    assert all(np.array_equal(one[n], other[n]) for n in names)


def test_the_same_system_gives_the_same_bytes(native_fmus, tmp_path):
    for name in "ab":
        write_container(tmp_path / name, "case1", case1(), STEP, 100)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_longer_step_takes_several_of_the_containers(native_fmus, tmp_path):
    path = tmp_path / "Loop.fmu"
    write_container(path, "case1", case1(), STEP, 100)
    fine = flown(path, 1, ["plant.V"])
    assert np.array_equal(flown(path, 1, ["plant.V"], step=5 * STEP)["plant.V"], fine["plant.V"][::5])


def test_our_check_finds_what_the_runtime_lacks_and_nothing_else(native_fmus, tmp_path):
    path = tmp_path / "Loop.fmu"
    write_container(path, "case1", case1(), STEP, 100)
    found = {(f.rule, f.variable) for f in cosim.check(path).findings if f.severity != "note"}
    assert found <= {("dynamic.legal-call", "fmi2SetDebugLogging")}, found


def gains(tmp_path, *connections, inner="", second=None):
    text = s.ssd(s.system("root", s.component("a") + s.component("b", u=second), "".join(connections)))
    return load_ssp(s.write(tmp_path / "gains.ssp", text))


@pytest.mark.parametrize("words,sentence", [
    (["plant.U"], "--connector plant.U: plant.U fits no output and no input that is free; did you mean plant."),
    (["engine.*"], "--connector engine.*: engine.* fits no output and no input that is free"),
    (["x=plant.*"], "--connector x=plant.* is not allowed: a name stands before one COMPONENT.VARIABLE."),
    (["=plant.V"], "--connector =plant.V is not allowed: a name stands before one COMPONENT.VARIABLE."),
    (["a\nb=plant.V"], "--connector 'a\\nb=plant.V' is not allowed: a name is one line of printable text."),
    (["x=plant.V", "x=plant.h"], "Two connectors are called x: plant.V and plant.h."),
    (["plant.mass=plant.V"], "Two connectors are called plant.mass: plant.V and plant.mass."),
])
def test_connectors_that_do_not_fit_are_refused(words, sentence, native_fmus, tmp_path):
    with pytest.raises(UsageError) as caught:
        write_container(tmp_path / "x.fmu", "case1", case1(), STEP, 100, words)
    assert str(caught.value).startswith(sentence)
    assert not (tmp_path / "x.fmu").exists()


@pytest.mark.parametrize("connections,sentence", [
    ([s.connection("a.y", "b.u"), s.connection("b.y", "a.u")],
     "The container cannot settle the algebraic loop of a.u, a.y, b.u, b.y at the start."),
    ([s.connection("a.y", "b.u", s.linear(2, 1))],
     "The container cannot convert a.y for b.u: it hands values on as they are, and this connection has factor 2, "
     "offset 1."),
])
def test_systems_that_the_runtime_cannot_fly_are_refused(connections, sentence, tmp_path):
    with gains(tmp_path, *connections) as system, pytest.raises(UsageError) as caught:
        write_container(tmp_path / "x.fmu", "gains", system, STEP, 1)
    assert sorted(str(caught.value)) == sorted(sentence)


def test_a_whole_number_for_a_real_is_refused(tmp_path):
    whole = '<ssd:Connector name="whole" kind="output"><ssc:Integer/></ssd:Connector>'
    text = s.ssd(s.system("root", s.component("a", more=whole) + s.component("b"), s.connection("a.whole", "b.u")))
    with load_ssp(s.write(tmp_path / "gains.ssp", text)) as system, pytest.raises(UsageError) as caught:
        write_container(tmp_path / "x.fmu", "gains", system, STEP, 1)
    assert str(caught.value) == "The container cannot connect a.whole (Integer) to b.u (Real)."


def test_a_text_that_xml_cannot_have_is_refused(tmp_path):
    with gains(tmp_path) as loaded, pytest.raises(UsageError) as caught:
        system = cosim.System([c.with_values({"label": "a\x1b"}) for c in loaded.components])
        write_container(tmp_path / "x.fmu", "x", system, STEP, 1)
    assert str(caught.value) == r"a.label = 'a\x1b' is not allowed: XML has no such characters."


def test_every_type_of_parameter_is_set(tmp_path):
    """Two FMUs of another make and of one name; what is set as a Boolean, a whole number and a text arrives."""
    with gains(tmp_path, s.connection("a.y", "b.u")) as loaded:
        values = {"k": 3.0, "n": 2, "on": True, "label": "a <b>"}
        system = cosim.System([c.with_values({"u": 2.0, **values} if c.name == "a" else {"on": False})
                               for c in loaded.components], loaded.connections)
        write_container(tmp_path / "Gains.fmu", "gains", system, 0.1, 1)
        variables = {v.name: v for v in fmpy.read_model_description(str(tmp_path / "Gains.fmu")).modelVariables}
        assert {n: variables[f"a.{n}"].start for n in values} == {"k": "3.0", "n": "2", "on": "true", "label": "a <b>"}
        result = flown(tmp_path / "Gains.fmu", 1, ["a.y", "b.y", "a.n", "a.on", "b.on"], step=0.1)
    assert (result["a.y"][1:] == 6).all() and (result["b.y"] == 0).all()
    assert (result["a.n"] == 2).all() and result["a.on"].all() and not result["b.on"].any()


@pytest.mark.parametrize("words,sentence", [
    (["case3"], "case3 is neither a scenario (case1, case2, hold) nor a file. Did you mean case2?"),
    (["case1", "--step", "0.03"], "--stop 100 s is not a whole number of communication steps of 0.03 s."),
    (["case1", "--step", "0"], "--step 0 and --stop 100 must be positive numbers of seconds."),
    (["none.ssp"], "none.ssp"),
])
def test_requests_that_cannot_be_carried_out_are_one_sentence(words, sentence, native_fmus):
    done = container(*words)
    assert done.returncode == 2 and sentence in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_options_of_scenarios_are_refused_for_an_ssp(tmp_path):
    s.write(tmp_path / "gains.ssp", s.ssd(s.system("root", s.component("a"))))
    done = container(tmp_path / "gains.ssp", "--plant", "instrumented")
    assert done.returncode == 2 and "is an SSP" in done.stderr
    done = container(tmp_path / "gains.ssp", "--set", "a.k=2", "--out", tmp_path / "Gains.fmu")
    assert done.returncode == 0, done.stderr
    assert fmpy.read_model_description(str(tmp_path / "Gains.fmu")).defaultExperiment.stopTime == "1.0"
    done = container(tmp_path / "gains.ssp", "--set", "c.k=2")
    assert done.returncode == 2 and "--set c: there is no such component" in done.stderr


def test_a_container_holds_fmi_2_only(tmp_path):
    text = ('<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t"><CoSimulation '
            'modelIdentifier="m"/><ModelVariables><Float64 name="y" valueReference="1" causality="output"/>'
            '</ModelVariables><ModelStructure><Output valueReference="1"/></ModelStructure></fmiModelDescription>')
    with zipfile.ZipFile(tmp_path / "three.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", text)
    with pytest.raises(UsageError, match=r"^c is FMI 3\.0; a container holds FMI 2\.0 only\.$"):
        write_container(tmp_path / "x.fmu", "x", cosim.System([cosim.Component("c", tmp_path / "three.fmu")]), STEP, 1)
