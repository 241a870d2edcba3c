"""Directional and adjoint derivatives of the files against the complex step on the models' equations."""
from importlib import import_module

import complex_step as m
import numpy as np
import pytest
from solved import Member

from cosim.vehicle.registry import MODELS
from fmus.interface import computed, names, variables

EXCHANGING = ("AhvPlant", "AhvController", "AhvBackstepping")
THOUSAND = pytest.param(1000, marks=pytest.mark.slow)
WIDTH = {"AhvPlant": 0.5, "AhvController": 0.05, "AhvBackstepping": 0.05}  # of nominal, how far states are moved


class Model:
    """A model's tables and functions, and the FMU made of it."""

    def __init__(self, name, fmu):
        self.fmu, self.model = fmu, import_module(MODELS[name])
        self.name, self.table = name, variables(self.model.VARIABLES)
        self.u = {v.name: v.start for v in self.table if v.causality == "input"}
        self.p = {v.name: v.start for v in self.table if v.causality == "parameter"}
        self.shown = computed(self.table)
        self.rates = [f"der({name})" for name in fmu.states]
        nominal = {v.name: v.nominal or 1.0 for v in self.table}
        self.width = {name: nominal[name] for name in self.u}
        self.nominals = np.array([nominal[name] for name in self.shown])

    def random_inputs(self, rng):
        return {name: value + 0.02 * rng.normal() * self.width[name] for name, value in self.u.items()}

    def random_state(self, rng, u):
        """An initial state, its continuous part moved; the memories of the vehicle's trim stay."""
        x = self.model.start(m, m.stepped(u, {}), m.stepped(self.p, {}))
        x = [value.real for value in x]
        for i, nominal in enumerate(self.fmu.nominal):
            x[i] += WIDTH[self.name] * rng.normal() * nominal
        return x

    def along(self, x, u, du, dx=(), dp=None):
        """What the outputs and the rates change by, in the order of `shown` and `rates`."""
        u, p = m.stepped(u, du), m.stepped(self.p, dp or {})
        x = m.stepped(x, [*dx, *[0.0] * (len(x) - len(dx))]) if x else self.model.start(m, u, p)
        y = self.model.outputs(m, 0.0, x, u, p)
        return np.array([m.derivative(value) for value in (*(y[name] for name in self.shown),
                                                           *self.model.derivative(m, 0.0, x, u, p))])

    def jacobian(self, unknowns, knowns, adjoint=False):
        """The file's Jacobian, a column for each known, or a row for each unknown by adjoint derivatives."""
        of = self.fmu.reference.__getitem__
        ask = self.fmu.fmu.getAdjointDerivative if adjoint else self.fmu.fmu.getDirectionalDerivative
        unknowns, knowns = list(map(of, unknowns)), list(map(of, knowns))
        if adjoint:
            return np.array([ask([unknown], knowns, [1.0], len(knowns)) for unknown in unknowns])
        return np.array([ask(unknowns, [known], [1.0]) for known in knowns]).T


@pytest.fixture(params=["native_fmus", "native_fmi3_fmus"])
def file(request):
    return request.getfixturevalue(request.param)


@pytest.fixture(params=EXCHANGING)
def model(request, file):
    member = Member(file[request.param])
    yield Model(request.param, member)
    member.close()


def worst_error(found, right, directions, at_least=1e-250):
    """Largest error of J d against the right one, in units of the sum of |J| |d| or `at_least`; by default what
    underflows is left out."""
    size = np.abs(found) @ np.abs(directions)
    return np.max(np.abs(found @ directions - right) / np.maximum(size, at_least))


@pytest.mark.parametrize("count", [10, THOUSAND])
def test_after_initialisation_by_inputs_and_states(model, count):
    rng, worst = np.random.default_rng(5), 0.0
    inputs, states = list(model.u), model.fmu.states
    for _ in range(count):
        u = model.random_inputs(rng)
        model.fmu.begin(at_start=u.items())
        x = model.random_state(rng, u)
        model.fmu.put(x[:len(states)])
        du, dx = rng.normal(size=len(inputs)), rng.normal(size=len(states)) * model.fmu.nominal
        found = model.jacobian([*model.shown, *model.rates], [*inputs, *states])
        right = model.along(x, u, dict(zip(inputs, du)), dx)
        worst = max(worst, worst_error(found, right, np.concatenate([du, dx])))
    print(f"{model.name}, {count} states: largest error {worst:.2g}")
    assert worst <= 1e-12


@pytest.mark.parametrize("count", [2, pytest.param(100, marks=pytest.mark.slow)])
def test_before_its_end_by_inputs_and_parameters(model, count):
    """Parameters change by their own size. Much of it cancels, for the start is a trim: so errors count from a
    variable's nominal on, and the laws' gains multiply the rounding of the trim."""
    rng, worst = np.random.default_rng(6), 0.0
    parameters = [v.name for v in model.table if v.causality == "parameter" and v.type == "Real"]
    inputs = names(model.table, "input")
    for _ in range(count):
        u = model.random_inputs(rng)
        model.fmu.fmu.reset()
        model.fmu.set(**u)
        du = rng.normal(size=len(inputs))
        dp = np.array([rng.normal() * (abs(model.p[name]) or 1.0) for name in parameters])
        found = model.jacobian(model.shown, [*inputs, *parameters])
        right = model.along(None, u, dict(zip(inputs, du)), dp=dict(zip(parameters, dp)))[:len(model.shown)]
        worst = max(worst, worst_error(found, right, np.concatenate([du, dp]), model.nominals))
    print(f"{model.name}, {count} starts: largest error {worst:.2g}")
    assert worst <= 1e-11


@pytest.mark.parametrize("name", EXCHANGING)
def test_adjoint_derivatives_are_the_rows_of_the_same_matrix(native_fmi3_fmus, name):
    member = Member(native_fmi3_fmus[name])
    model = Model(name, member)
    knowns, unknowns = [*model.u, *member.states], [*model.shown, *model.rates]
    member.begin()
    columns = model.jacobian(unknowns, knowns)
    assert np.any(columns) and np.array_equal(model.jacobian(unknowns, knowns, adjoint=True), columns)
    seed, of = np.linspace(-1, 1, len(unknowns)), member.reference.__getitem__
    found = member.fmu.getAdjointDerivative(list(map(of, unknowns)), list(map(of, knowns)), list(seed), len(knowns))
    assert found == pytest.approx(seed @ columns, rel=1e-12, abs=1e-12 * np.abs(columns).max())
    member.close()


