"""Traces a model's functions into CasADi functions of flat vectors."""
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace

import casadi

from . import symbols
from .functions import functions
from .interface import computed, names, variables


@dataclass(frozen=True)
class Trace:
    """A model's functions on flat column vectors, in the order of its table.

    prepare (p, h) -> c; start (u, p) -> x; advance (t, h, x, u, p, c) -> x; outputs (t, x, u, p) -> y;
    derivative (t, x, u, p) -> rates of the first entries of x, None where the model does not give it.
    """
    prepare: casadi.Function
    start: casadi.Function
    advance: casadi.Function
    outputs: casadi.Function
    derivative: casadi.Function | None = None

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of x, u, p, y, c."""
        return {"x": self.start.size1_out(0), "u": self.start.size1_in(0), "p": self.start.size1_in(1),
                "y": self.outputs.size1_out(0), "c": self.prepare.size1_out(0)}


def symbol_namespace(vector: casadi.SX, members: list[str]) -> SimpleNamespace:
    """The entries of a column vector as attributes `members`, in this order."""
    return SimpleNamespace(**{name: vector[i] for i, name in enumerate(members)})


def trace_model(model: ModuleType) -> Trace:
    """Trace `model` (see `fmus.interface`) with CasADi's scalar symbols. `fmus.check_model.checked_trace` finds its
    mistakes as well."""
    table = variables(model.VARIABLES)
    input_names, parameter_names = names(table, "input"), names(table, "parameter")
    t, h = casadi.SX.sym("t"), casadi.SX.sym("h")
    u, p = casadi.SX.sym("u", len(input_names)), casadi.SX.sym("p", len(parameter_names))
    un, pn = symbol_namespace(u, input_names), symbol_namespace(p, parameter_names)

    does = functions(model)
    x0, c0 = does.start(symbols, un, pn), does.prepare(symbols, pn, h)
    x, c = casadi.SX.sym("x", len(x0)), casadi.SX.sym("c", len(c0))
    xs, cs = [x[i] for i in range(len(x0))], [c[i] for i in range(len(c0))]
    y = does.outputs(symbols, t, xs, un, pn)

    rates = model.derivative(symbols, t, xs, un, pn) if hasattr(model, "derivative") else None

    def function(name: str, inputs: dict[str, casadi.SX], output: list[casadi.SX], output_name: str) -> casadi.Function:
        result = casadi.vertcat(*output) if output else casadi.SX(0, 1)
        return casadi.Function(name, list(inputs.values()), [result], list(inputs), [output_name])

    return Trace(
        prepare=function("prepare", {"p": p, "h": h}, c0, "c"),
        start=function("start", {"u": u, "p": p}, x0, "x0"),
        advance=function("advance", {"t": t, "h": h, "x": x, "u": u, "p": p, "c": c},
                         does.advance(symbols, t, h, xs, un, pn, cs), "x1"),
        outputs=function("outputs", {"t": t, "x": x, "u": u, "p": p}, [y[name] for name in computed(table)], "y"),
        derivative=None if rates is None else function("derivative", {"t": t, "x": x, "u": u, "p": p}, rates, "rates"))
