"""Which computed variables of a model depend on which known ones, from the sparsity of its traced functions."""
from dataclasses import dataclass
from types import ModuleType

import casadi

from .interface import computed, names, variables
from .trace import Trace

TIME = "time"  # what stands for the time among the names of knowns


@dataclass(frozen=True)
class Dependencies:
    """Name of a computed variable -> names of the variables that it depends on directly, in the table's order.

    `after_step` are the inputs, continuous states and TIME that decide on it at a communication point; `at_start` the
    inputs, parameters and TIME that decide on its initial value. Fixed parameters do not change after the start, so
    that `after_step` leaves them out.
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
    table = variables(model.VARIABLES)
    inputs, parameters = names(table, "input"), names(table, "parameter")
    t, x, u, p = (trace.outputs.sx_in(name) for name in "txup")

    def found(y: casadi.SX, knowns: casadi.SX, known_names: list[str]) -> dict[str, list[str]]:
        return {name: [known_names[i] for i in columns] for name, columns in zip(computed(table), rows(y, knowns))}

    return Dependencies(
        found(trace.outputs(t, x, u, p), casadi.vertcat(u, t), [*inputs, TIME]),
        found(trace.outputs(t, trace.start(u, p), u, p), casadi.vertcat(u, p, t), [*inputs, *parameters, TIME]))
