"""Every variable of a model's FMU, in the order of value references, which both versions of FMI and the C have."""
from types import ModuleType

from .interface import Variable, states, variables
from .units import per_second


def all_variables(model: ModuleType) -> list[Variable]:
    """The variables of `model` as records, each at its value reference: the rows of its table; the continuous states
    that are no row, with the causality "local"; the derivatives of all continuous states, also "local", which name
    their state in `derivative_of`; last the time, with the causality "independent", which FMI 2.0 does not list."""
    table, continuous = variables(model.VARIABLES), states(model)
    found = [*table, *(v for v in continuous if v.causality == "local")]
    for state in continuous:
        found.append(rate(state, len(found)))
    taken = {v.name for v in found}
    name = next(name for name in ("time", "independent_time", "fmi_time") if name not in taken)
    return [*found, Variable(name, "independent", "s", None, None, None, None, "simulation time", len(found), None)]


def rate(state: Variable, value_reference: int) -> Variable:
    """The derivative of a continuous state."""
    return Variable(f"der({state.name})", "local", per_second(state.unit), None, None, None, None,
                    f"rate of {state.name}", value_reference,
                    per_second(state.display_unit) if state.display_unit else None, derivative_of=state.name)
