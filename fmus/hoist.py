"""What a model's step computes of parameters alone is computed once: its functions as the native flavour has them."""
from dataclasses import dataclass

import casadi

from .trace import Trace


@dataclass(frozen=True)
class Hoisted:
    """The functions of a `Trace`, equal to rounding, with the numbers that are known before a step as arguments.

    constants (p) -> k; prepare (p, h, k) -> c; hold (h, u, p, k, c) -> w; advance (t, h, x, u, p, k, c, w) -> x;
    outputs (t, x, u, p, k) -> y; finish (t, h, x, u, p, k, c, w, end) -> (x, y), an advance and the outputs at its
    end, which share what they can.
    """
    constants: casadi.Function
    prepare: casadi.Function
    hold: casadi.Function
    advance: casadi.Function
    outputs: casadi.Function
    finish: casadi.Function

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of k, c and w."""
        return {"k": self.constants.size1_out(0), "c": self.prepare.size1_out(0), "w": self.hold.size1_out(0)}


def hoist(expressions: list[casadi.SX], known: list[casadi.SX], name: str
          ) -> tuple[list[casadi.SX], list[casadi.SX], list[casadi.SX]]:
    """`expressions` with a new symbol for each largest part that has none but `known` symbols; these symbols; and the
    parts that they stand for. A division by such a part becomes a product with its reciprocal."""
    expressions = casadi.cse(expressions)
    given = {symbol.element_hash() for symbol in known}
    others = [s for s in casadi.symvar(casadi.veccat(*expressions)) if s.element_hash() not in given]
    program = casadi.Function("program", [casadi.veccat(*known), casadi.veccat(*others)], expressions)
    inputs, work = [known, others], {}  # work: place -> expression, and whether it is known
    results = [casadi.SX(e.sparsity()) for e in expressions]
    symbols, values, reciprocals = {}, [], {}

    def taken(value: casadi.SX, early: bool) -> casadi.SX:
        if not early or value.is_leaf():
            return value
        key = value.element_hash()
        if key not in symbols:
            symbols[key] = casadi.SX.sym(f"{name}{len(symbols)}")
            values.append(value)
        return symbols[key]

    for i in range(program.n_instructions()):
        operation, into, of = program.instruction_id(i), program.instruction_output(i), program.instruction_input(i)
        if operation == casadi.OP_INPUT:
            work[into[0]] = inputs[of[0]][of[1]], of[0] == 0
        elif operation == casadi.OP_CONST:
            work[into[0]] = casadi.SX(program.instruction_constant(i)), True
        elif operation == casadi.OP_OUTPUT:
            results[into[0]].nz[into[1]] = taken(*work[of[0]])
        else:
            operands = [work[place] for place in of]
            early = all(is_known for _, is_known in operands)
            if operation == casadi.OP_DIV and operands[1][1] and not early:
                divisor = operands[1][0]
                reciprocal = reciprocals.setdefault(divisor.element_hash(), 1 / divisor)
                work[into[0]] = operands[0][0] * taken(reciprocal, True), False
            else:
                parts = [value if early else taken(value, is_known) for value, is_known in operands]
                apply = casadi.SX.unary if len(parts) == 1 else casadi.SX.binary
                work[into[0]] = apply(operation, *parts), early
    return results, list(symbols.values()), values


def hoisted(trace: Trace) -> Hoisted:
    """The functions of `trace` with what is known before a step taken out."""
    n = trace.sizes
    t, h, end = (casadi.SX.sym(name) for name in ("t", "h", "end"))
    x, u, p, c = (casadi.SX.sym(name, n[name]) for name in ("x", "u", "p", "c"))
    given, held, own = (casadi.vertsplit(vector) if vector.numel() else [] for vector in (p, u, c))

    later, y = trace.advance(t, h, x, u, p, c), trace.outputs(t, x, u, p)
    (later, y), k, of_parameters = hoist([later, y], given, "k")
    k = casadi.vertcat(*k, casadi.SX(0, 1))
    outputs = casadi.Function("outputs", [t, x, u, p, k], [y])

    step = [later, outputs(end, later, u, p, k)]
    step, further, of_step = hoist(step, [h, *given, *casadi.vertsplit(k), *own], "c")
    prepared = casadi.vertcat(c, *of_step)
    c = casadi.vertcat(c, *further)
    step, w, of_inputs = hoist(step, [h, *given, *casadi.vertsplit(k), *casadi.vertsplit(c), *held], "w")
    w = casadi.vertcat(*w, casadi.SX(0, 1))
    prepared = casadi.substitute(prepared, casadi.vertcat(*own, casadi.SX(0, 1)), trace.prepare(p, h))

    def function(name: str, arguments: list[casadi.SX], *results: casadi.SX) -> casadi.Function:
        return casadi.Function(name, arguments, [casadi.densify(result) for result in results])

    before = [t, h, x, u, p, k, c, w]
    return Hoisted(function("constants", [p], casadi.vertcat(*of_parameters, casadi.SX(0, 1))),
                   function("prepare", [p, h, k], prepared),
                   function("hold", [h, u, p, k, c], casadi.vertcat(*of_inputs, casadi.SX(0, 1))),
                   function("advance", before, step[0]), outputs,
                   function("finish", [*before, end], *casadi.cse(step)))
