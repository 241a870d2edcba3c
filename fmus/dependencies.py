"""Which computed variables of a model depend on which known ones, from the sparsity of its traced functions."""
from dataclasses import dataclass
from types import ModuleType

import casadi

from .interface import computed, names, states, variables
from .references import all_variables
from .trace import Trace


@dataclass(frozen=True)
class Dependencies:
    """Name of what is computed (what `outputs` returns, continuous states, their derivatives) -> names of the variables
    that it depends on directly, in the order of value references.

    `after_step` are the inputs, continuous states and time that decide on it at a communication point; `at_start` the
    inputs, parameters and time that decide on its initial value. Fixed parameters do not change after the start, so
    that `after_step` leaves them out, and of the states only what else shows them has an entry there.
    """
    after_step: dict[str, list[str]]
    at_start: dict[str, list[str]]


def rows(expression: casadi.SX, knowns: casadi.SX) -> list[list[int]]:
    """For each entry of `expression` the places in `knowns` that it depends on."""
    function = casadi.Function("f", [knowns], [expression], {"allow_free": True})
    pattern = function.jac_sparsity(0, 0)
    found: list[list[int]] = [[] for _ in range(pattern.size1())]
    for row, column in zip(*pattern.get_triplet()):
        found[row].append(column)
    return found


def dependencies(model: ModuleType, trace: Trace) -> Dependencies:
    """What the computed variables of `model` depend on."""
    table, everything, continuous = variables(model.VARIABLES), all_variables(model), states(model)
    place = {v.name: v.value_reference for v in everything}
    time = everything[-1].name
    inputs, parameters, n = names(table, "input"), names(table, "parameter"), len(continuous)
    t, x, u, p = (trace.outputs.sx_in(name) for name in "txup")
    shown = [*computed(table), *(v.name for v in everything if v.derivative_of)]

    def all_of(x: casadi.SX) -> casadi.SX:
        rates = trace.derivative(t, x, u, p) if trace.derivative else casadi.SX(0, 1)
        return casadi.vertcat(trace.outputs(t, x, u, p), rates)

    def found(what: list[str], y: casadi.SX, knowns: casadi.SX, known_names: list[str]) -> dict[str, list[str]]:
        return {name: sorted((known_names[i] for i in columns), key=place.__getitem__)
                for name, columns in zip(what, rows(y, knowns))}

    start = trace.start(u, p)
    hidden = [i for i, v in enumerate(continuous) if v.causality == "local"]
    return Dependencies(
        found(shown, all_of(x), casadi.vertcat(u, t, x[:n]), [*inputs, time, *(v.name for v in continuous)]),
        found([*shown, *(continuous[i].name for i in hidden)], casadi.vertcat(all_of(start), start[hidden]),
              casadi.vertcat(u, p, t), [*inputs, *parameters, time]))
