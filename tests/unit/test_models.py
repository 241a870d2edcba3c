"""What every model must keep: a consistent table, presets that fit it, the same numbers on both backends."""
from importlib import import_module

import casadi
import numpy as np
import pytest
from oracle import starts

from cosim.vehicle.registry import MODELS
from fmus import floats
from fmus.integrators import advancing
from fmus.interface import computed, names, variables
from fmus.trace import trace_model
from fmus.units import si_base


@pytest.fixture(params=sorted(MODELS))
def model(request):
    return import_module(MODELS[request.param])


def test_outputs_are_those_of_the_table(model):
    table = variables(model.VARIABLES)
    u, p = starts(model, "input"), starts(model, "parameter")
    y = model.outputs(floats, 0.0, model.start(floats, u, p), u, p)
    assert set(y) == set(computed(table))


def test_units_are_known_and_every_variable_is_described(model):
    for v in variables(model.VARIABLES):
        assert v.unit == "" or si_base(v.unit), v
        assert v.description, v


def test_presets_set_parameters_within_their_limits_and_the_first_is_the_default(model):
    table = {v.name: v for v in variables(model.VARIABLES)}
    for values in model.PRESETS.values():
        for name, value in values.items():
            v = table[name]
            assert v.causality == "parameter"
            assert v.minimum is None or value >= v.minimum
            assert v.maximum is None or value <= v.maximum
    first = next(iter(model.PRESETS.values()))
    assert {name: table[name].start for name in first} == first
    assert len({frozenset(values) for values in model.PRESETS.values()}) == 1, "presets must set the same parameters"


def test_both_backends_give_the_same_numbers(model):
    table = variables(model.VARIABLES)
    u, p = starts(model, "input"), starts(model, "parameter")
    flat_u = [float(getattr(u, n)) for n in names(table, "input")]
    flat_p = [float(getattr(p, n)) for n in names(table, "parameter")]
    traced, h = trace_model(model), 0.002

    def close(a, b):
        return np.allclose(np.array(a, dtype=float), np.array(b).ravel(), rtol=1e-13, atol=1e-15)

    x = model.start(floats, u, p)
    c = model.prepare(floats, p, h) if hasattr(model, "prepare") else []
    stepped = advancing(model)(floats, 0.3, h, x, u, p, c)
    y = model.outputs(floats, 0.3, stepped, u, p)
    assert close(x, traced.start(flat_u, flat_p))
    assert np.allclose(c, np.array(traced.prepare(flat_p, h)).ravel(), rtol=1e-12, atol=1e-13)
    column = casadi.DM(x) if x else casadi.DM(0, 1)
    traced_step = np.array(traced.advance(0.3, h, column, flat_u, flat_p, c)).ravel()
    assert np.allclose(stepped, traced_step, rtol=1e-12, atol=1e-13)
    column = casadi.DM(stepped) if stepped else casadi.DM(0, 1)
    assert np.allclose([float(y[n]) for n in computed(table)],
                       np.array(traced.outputs(0.3, column, flat_u, flat_p)).ravel(), rtol=1e-11, atol=1e-12)
