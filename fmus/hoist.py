"""What is known before a step is computed before it, once: a model's functions as the native flavour calls them."""
from dataclasses import dataclass

import casadi

from .trace import Trace

NONE = casadi.SX(0, 1)
STEPS = {casadi.OP_FLOOR, casadi.OP_CEIL}
COMPARISONS = {casadi.OP_LT, casadi.OP_LE, casadi.OP_EQ, casadi.OP_NE}
EXACT = {casadi.OP_ADD, casadi.OP_SUB, casadi.OP_MUL, casadi.OP_DIV, casadi.OP_NEG, casadi.OP_SQ, casadi.OP_TWICE,
         casadi.OP_FABS, casadi.OP_FMIN, casadi.OP_FMAX, casadi.OP_IF_ELSE_ZERO, casadi.OP_SQRT, casadi.OP_INV}
CHEAP = 1.1  # outputs that make an advance longer by no more than this are taken along: half the code is in the caches


@dataclass(frozen=True)
class Hoisted:
    """The functions of a `Trace`, equal to rounding, with what is known before a step as arguments.

    constants (p) -> k, prepare (p, h, k) -> c and hold (h, u, p, k, c) -> w are what parameters, the step, and the held
    inputs decide; advance (t, h, x, u, p, k, c, w) -> x; finish (t, h, x, u, p, k, c, w, end) -> (x, y) is an advance
    and the outputs after it; outputs (t, x, u, p, k) -> y; derivative (t, x, u, p, k) -> rates.
    """
    constants: casadi.Function
    prepare: casadi.Function
    hold: casadi.Function
    advance: casadi.Function
    finish: casadi.Function
    outputs: casadi.Function
    derivative: casadi.Function

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of k, c and w."""
        return {"k": self.constants.size1_out(0), "c": self.prepare.size1_out(0), "w": self.hold.size1_out(0)}

    @property
    def advances_apart(self) -> bool:
        """Whether it is worth to have `advance`, where `finish` does the same and more."""
        return bool(self.finish.n_instructions() > CHEAP * self.advance.n_instructions())


def entries(*vectors: casadi.SX) -> list[casadi.SX]:
    """The entries of column vectors, one after the other."""
    return [entry for vector in vectors if vector.numel() for entry in casadi.vertsplit(vector)]


def before_jumps(program: casadi.Function) -> set[int]:
    """The instructions that decide on which side of a jump a number lies: what is compared, and the arithmetic that
    leads to a floor or ceil. They are computed as they stand: 49 / 49 is 1, and 49 * (1 / 49) is not."""
    found: set[int] = set()
    deciding: set[int] = set()  # places whose content leads to a step of floor, below this instruction
    compared: set[int] = set()
    for i in reversed(range(program.n_instructions())):
        operation, into, of = program.instruction_id(i), program.instruction_output(i), program.instruction_input(i)
        if operation in (casadi.OP_INPUT, casadi.OP_OUTPUT):
            continue
        leads_to_a_step = into[0] in deciding
        if leads_to_a_step or into[0] in compared:
            found.add(i)
        deciding.difference_update(into)
        compared.difference_update(into)
        if operation in STEPS or (leads_to_a_step and operation in EXACT):
            deciding.update(of)
        elif operation in COMPARISONS:
            compared.update(of)
    return found


def hoist(expressions: list[casadi.SX], known: list[casadi.SX], name: str
          ) -> tuple[list[casadi.SX], casadi.SX, casadi.SX]:
    """`expressions` with a new symbol for each largest part that has no symbols but `known`; these new symbols, called
    `name`; the parts that they stand for. A division by such a part becomes a product with its reciprocal,
    except `before_jumps`."""
    expressions = casadi.cse(expressions)
    given = {symbol.element_hash() for symbol in known}
    others = [s for s in casadi.symvar(casadi.veccat(*expressions)) if s.element_hash() not in given]
    program = casadi.Function("program", [casadi.veccat(*known), casadi.veccat(*others)], expressions)
    exact = before_jumps(program)
    inputs, results = [known, others], [casadi.SX(e.sparsity()) for e in expressions]
    symbols: dict[int, casadi.SX] = {}
    parts: list[casadi.SX] = []
    reciprocals: dict[int, tuple[casadi.SX, casadi.SX]] = {}  # the divisor is kept, for a hash is its while it lives
    work: dict[int, tuple[casadi.SX, bool]] = {}  # place -> what stands there, and whether it is known

    def taken(value: casadi.SX, early: bool) -> casadi.SX:
        if not early or value.is_leaf():
            return value
        key = value.element_hash()
        if key not in symbols:
            symbols[key] = casadi.SX.sym(f"{name}{len(symbols)}")
            parts.append(value)
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
            if operation == casadi.OP_DIV and operands[1][1] and not early and i not in exact:
                divisor = operands[1][0]
                _, reciprocal = reciprocals.setdefault(divisor.element_hash(), (divisor, 1 / divisor))
                work[into[0]] = operands[0][0] * taken(reciprocal, True), False
            else:
                values = [value if early else taken(value, is_known) for value, is_known in operands]
                apply = casadi.SX.unary if len(values) == 1 else casadi.SX.binary
                work[into[0]] = apply(operation, *values), early
    return results, casadi.vertcat(*symbols.values(), NONE), casadi.vertcat(*parts, NONE)


def hoisted(trace: Trace, rates: casadi.Function) -> Hoisted:
    """The functions of `trace`, and `rates` as its derivative, with what is known before a step taken out."""
    n = trace.sizes
    t, h, end = (casadi.SX.sym(name) for name in ("t", "h", "end"))
    x, u, p, own = (casadi.SX.sym(name, n[name]) for name in ("x", "u", "p", "c"))

    def function(name: str, arguments: list[casadi.SX], *results: casadi.SX) -> casadi.Function:
        return casadi.Function(name, arguments, [casadi.densify(result) for result in results])

    expressions = [trace.advance(t, h, x, u, p, own), trace.outputs(t, x, u, p), rates(t, x, u, p)]
    (later, y, rate), k, of_parameters = hoist(expressions, entries(p), "k")
    outputs = function("outputs", [t, x, u, p, k], y)
    step = [later, outputs(end, later, u, p, k)]
    step, further, of_step = hoist(step, entries(h, p, k, own), "c")
    prepared = casadi.substitute(casadi.vertcat(own, of_step), own, trace.prepare(p, h))
    c = casadi.vertcat(own, further)
    step, w, of_inputs = hoist(step, entries(h, p, k, c, u), "w")
    return Hoisted(function("constants", [p], of_parameters), function("prepare", [p, h, k], prepared),
                   function("hold", [h, u, p, k, c], of_inputs),
                   function("advance", [t, h, x, u, p, k, c, w], step[0]),
                   function("finish", [t, h, x, u, p, k, c, w, end], *casadi.cse(step)), outputs,
                   function("derivative", [t, x, u, p, k], rate))
