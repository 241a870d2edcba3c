"""The numbers of every model stay what they were: its outputs on short flights, its limits and its nominal values.

The flights are recorded in model_numbers.json: every preset as it is, and parameters drawn about their start values,
so that switches, delays and filters that are off by default are on in some. Whoever changes a number on purpose
records them again, and sees in the file what changed: `python tests/unit/test_model_numbers.py`.
"""
import json
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cosim.vehicle.registry import MODELS
from fmus import floats
from fmus.integrators import advancing
from fmus.interface import variables

RECORD = Path(__file__).with_name("model_numbers.json")
STEPS, DRAWN = 8, 4


def flown(model, flight):
    """The outputs after STEPS internal steps: inputs vary from step to step, by name the value and its change."""
    changed = flight.get("parameters") or model.PRESETS[flight["preset"]]
    p = SimpleNamespace(**{v.name: v.start for v in variables(model.VARIABLES) if v.causality == "parameter"} | changed)
    h, t = flight["step"], flight["time"]

    def inputs(k):
        return SimpleNamespace(**{name: value + k * change for name, (value, change) in flight["inputs"].items()})

    x = model.start(floats, inputs(0), p)
    c = model.prepare(floats, p, h) if hasattr(model, "prepare") else []
    for k in range(STEPS):
        x = advancing(model)(floats, t + k * h, h, x, inputs(k), p, c)
    return {name: float(value) for name, value in model.outputs(floats, t + STEPS * h, x, inputs(STEPS), p).items()}


def drawn(rng, v):
    """A value of the parameter `v` about its start value; of one that is off (0 or for ever), a value that is on."""
    if v.type == "Boolean":
        return bool(rng.integers(2))
    if v.start == 0 or v.start == 1e6:
        low, high = (5, 100) if v.start else (0, 0.1 if v.unit.startswith("rad") else 1)
        value = rng.uniform(low, high)
    else:
        value = v.start * rng.uniform(0.9, 1.1)
    low, high = (v.minimum if v.minimum is not None else -np.inf), (v.maximum if v.maximum is not None else np.inf)
    return float(np.clip(value, low, high))


def flights(model, seed):
    """What to fly: each preset, then DRAWN draws that end with finite numbers."""
    rng, table = np.random.default_rng(seed), variables(model.VARIABLES)

    def flight(**what):
        inputs = {v.name: (v.start + 0.02 * v.nominal * rng.uniform(-1, 1), 0.01 * v.nominal * rng.normal())
                  for v in table if v.causality == "input"}
        return {"time": float(rng.uniform(0, 150)), "step": 0.005, "inputs": inputs, **what}

    found = [flight(preset=name) for name in model.PRESETS]
    while len(found) < len(model.PRESETS) + DRAWN:
        new = flight(parameters={v.name: drawn(rng, v) for v in table if v.causality == "parameter"})
        try:
            if np.isfinite(list(flown(model, new).values())).all():
                found.append(new)
        except (OverflowError, ValueError, ZeroDivisionError):
            pass
    return found


def limits(model):
    """What an importer reads of the table: name -> start, min, max, nominal."""
    return {v.name: [v.start, v.minimum, v.maximum, v.nominal] for v in variables(model.VARIABLES)}


@pytest.fixture(params=MODELS)
def model(request):
    return import_module(MODELS[request.param])


@pytest.fixture
def recorded(model):
    return json.loads(RECORD.read_text())[model.NAME]


def test_flights_end_where_they_did(model, recorded):
    for flight in recorded["flights"]:
        assert flown(model, flight) == pytest.approx(flight["outputs"], rel=1e-9, abs=1e-11)


def test_limits_are_what_they_were(model, recorded):
    assert limits(model) == recorded["limits"]


def main():
    """Record the numbers as they are now."""
    lines = []
    for seed, name in enumerate(MODELS):
        model = import_module(MODELS[name])
        flown_now = [{**flight, "outputs": flown(model, flight)} for flight in flights(model, seed)]
        rows = ",\n".join(json.dumps(flight) for flight in flown_now)
        lines.append(f'"{name}": {{"limits": {json.dumps(limits(model))},\n"flights": [\n{rows}]}}')
    RECORD.write_text("{" + ",\n".join(lines) + "}\n")


if __name__ == "__main__":
    main()
