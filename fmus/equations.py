"""A model's functions as formulas: its Python source, statement by statement, as MathML.

Nothing is written a second time: what is shown is what flies. A statement that is no formula is shown as code.
"""
import ast
import io
import re
import tokenize
from html import escape

LETTERS = ("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu",
           "xi", "omicron", "pi", "rho", "final sigma", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega")
GREEK = {name: chr(0x3B1 + i) for i, name in enumerate(LETTERS)}
GREEK |= {name.capitalize(): chr(ord(letter) - 32) for name, letter in GREEK.items()}
ACCENTS = {"dot": "˙", "ddot": "¨"}
OWNERS = ("m", "p", "u", "s", "c")  # backend, parameters, inputs, state: the variable's own name says enough
OPERATORS: dict[type[ast.AST], tuple[str, int]] = {  # sign and how strongly it binds
    ast.Or: ("∨", 1), ast.And: ("∧", 2), ast.Lt: ("&lt;", 4), ast.LtE: ("≤", 4), ast.Gt: ("&gt;", 4),
    ast.GtE: ("≥", 4), ast.Eq: ("=", 4), ast.NotEq: ("≠", 4), ast.Add: ("+", 5), ast.Sub: ("−", 5),
    ast.Mult: ("⋅", 6), ast.Mod: ("mod", 6)}
FENCED = {"fabs": ("|", "|"), "abs": ("|", "|"), "floor": ("⌊", "⌋"), "ceil": ("⌈", "⌉")}
ATOM, NEGATIVE = 9, 5


def tag(name: str, *content: str) -> str:
    """An element of MathML."""
    return f"<{name}>{''.join(content)}</{name}>"


def symbol(name: str) -> str:
    """A variable's name as a symbol: gamma_d is a Greek letter with a subscript, eta1_dot has a dot above."""
    base, *words = name.strip("_").split("_")
    letters, digits = re.fullmatch(r"(.*?)(\d*)", base).groups() if base else (name, "")  # type: ignore[union-attr]
    letters, digits = (letters, digits) if letters else (base, "")
    shown = tag("mi", escape(GREEK.get(letters, letters)))
    accents = [word for word in words if word in ACCENTS]
    below = [GREEK.get(word, word) for word in [digits, *words] if word and word not in ACCENTS]
    for accent in accents:
        shown = tag("mover", shown, tag("mo", ACCENTS[accent]))
    return tag("msub", shown, tag("mtext", escape(", ".join(below)))) if below else shown


def fenced(content: str, left: str = "(", right: str = ")") -> str:
    """`content` between brackets."""
    return tag("mrow", tag("mo", left), content, tag("mo", right))


def bracketed(content: str, within: int) -> str:
    """A fraction or a power, in brackets where it is the base of a power."""
    return fenced(content) if within == ATOM else content


def listed(nodes: list[ast.expr]) -> str:
    """Expressions with commas between them."""
    return tag("mrow", tag("mo", ",").join(formula(node) for node in nodes))


def cases(condition: ast.expr, yes: ast.expr, no: ast.expr) -> str:
    """One of two values."""
    rows = [tag("mtr", tag("mtd", formula(yes)), tag("mtd", tag("mtext", "if&#160;"), formula(condition))),
            tag("mtr", tag("mtd", formula(no)), tag("mtd", tag("mtext", "else")))]
    return tag("mrow", tag("mo", "{"), tag("mtable", *rows))


def chained(nodes: list[ast.expr], operators: list[ast.AST], within: int) -> str:
    """Expressions with operators between them, in brackets where `within` binds as strongly."""
    strength = OPERATORS[type(operators[0])][1]
    inner = formula(nodes[0], 0 if isinstance(nodes[0], ast.UnaryOp) else strength)
    for operator, node in zip(operators, nodes[1:]):
        inner += tag("mo", OPERATORS[type(operator)][0]) + formula(node, strength + isinstance(operator, ast.Sub))
    inner = tag("mrow", inner)
    return fenced(inner) if within > strength else inner


def call(node: ast.Call, within: int) -> str:
    """A function's value, see `formula`."""
    name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    given = [a for a in node.args if not (isinstance(a, ast.Name) and a.id == "m")]
    if not name or node.keywords or any(isinstance(a, ast.Starred) for a in given):
        return code(node)
    if name in ("both", "either") and len(given) == 2:
        return formula(ast.BoolOp(ast.And() if name == "both" else ast.Or(), given), within)
    if name == "where" and len(given) == 3:
        return cases(*given)
    if name == "sqrt":
        return tag("msqrt", listed(given))
    if name == "exp":
        return bracketed(tag("msup", tag("mi", "e"), listed(given)), within)
    if name in FENCED:
        return fenced(listed(given), *FENCED[name])
    if name == "sum" and len(given) == 1 and isinstance(given[0], ast.ListComp | ast.GeneratorExp):
        term = given[0]
        below = tag("mtext", escape(", ".join(f"{ast.unparse(g.target)} in {ast.unparse(g.iter)}"
                                              for g in term.generators)))
        return tag("mrow", tag("munder", tag("mo", "∑"), below), formula(term.elt, 6))
    return tag("mrow", tag("mtext", escape(name)), fenced(listed(given)))


def code(node: ast.AST) -> str:
    """What is no formula, as it is written."""
    return tag("mtext", escape(ast.unparse(node)))


def formula(node: ast.expr, within: int = 0) -> str:
    """An expression as MathML, in brackets where the operator around it binds more strongly (`within`)."""
    match node:
        case ast.Name(id=name):
            return symbol(name)
        case ast.Attribute(value=ast.Name(id=owner), attr=name):
            return symbol(name) if owner in OWNERS else symbol(f"{name}_{owner}")
        case ast.Constant(value=bool() | None | str()):
            return tag("mtext", escape(str(node.value)))
        case ast.Constant(value=value):
            return tag("mn", escape(repr(value)))
        case ast.Subscript(value=value, slice=place):
            return tag("msub", formula(value, ATOM), tag("mtext", escape(ast.unparse(place))))
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return bracketed(tag("mfrac", formula(left), formula(right)), within)
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            return bracketed(tag("msup", formula(left, ATOM), formula(right)), within)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return chained([left, right], [op], within)
        case ast.BoolOp(op=op, values=values):
            return chained(values, [op] * (len(values) - 1), within)
        case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in OPERATORS for op in ops):
            return chained([left, *others], list(ops), within)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = tag("mrow", tag("mo", "−"), formula(operand, NEGATIVE + 1))
            return fenced(inner) if within > NEGATIVE else inner
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return tag("mrow", tag("mo", "¬"), formula(operand, ATOM))
        case ast.IfExp(test=test, body=body, orelse=otherwise):
            return fenced(cases(test, body, otherwise), "", "")
        case ast.Tuple(elts=elements) | ast.List(elts=elements):
            return fenced(listed(elements))
        case ast.Call():
            return call(node, within)
    return code(node)


def row(content: str, depth: int, remark: str = "") -> str:
    """A line of the page; `remark` stands at its right."""
    return (f'<div class="eq" style="margin-left:{2 * depth}em"><span>{content}</span>'
            f"<small>{escape(remark)}</small></div>")


def math(*content: str) -> str:
    """A formula of its own."""
    return f'<math display="inline">{"".join(content)}</math>'


def equation(left: str, right: ast.expr, depth: int, remark: str) -> list[str]:
    """The row of an equation, none where both sides look alike."""
    shown = formula(right)
    return [] if shown == left else [row(math(left, tag("mo", "="), shown), depth, remark)]


def named_values(node: ast.expr) -> list[tuple[str, ast.expr]]:
    """The names and values of a dictionary or a namespace; what comes from elsewhere under no name."""
    match node:
        case ast.Dict(keys=keys, values=values):
            return [(str(getattr(key, "value", "")), value) for key, value in zip(keys, values)]
        case ast.Call(func=ast.Name(id="SimpleNamespace"), args=[], keywords=keywords):
            return [(keyword.arg or "", keyword.value) for keyword in keywords]
    return []


def lines(statements: list[ast.stmt], name: str, remarks: dict[int, str], depth: int = 0) -> list[str]:
    """The rows of statements of the function `name`; `remarks` has the comment at the end of each line."""
    found = []
    for node in statements:
        remark = remarks.get(node.end_lineno or 0, "")
        match node:
            case ast.Expr(value=ast.Constant()):
                pass
            case ast.Assign(targets=[target], value=value):
                found += equation(formula(target), value, depth, remark)
            case ast.Return(value=ast.expr() as value) if named_values(value):
                for key, part in named_values(value):
                    remark = remarks.get(part.end_lineno or 0, "")
                    found += (equation(symbol(key), part, depth, remark) if key else
                              [row(f"<code>{escape(ast.unparse(part))}</code>", depth, remark)])
            case ast.Return(value=ast.expr() as value):
                found += equation(tag("mtext", escape(name)), value, depth, remark)
            case ast.FunctionDef(body=body):
                given = ", ".join(argument.arg for argument in node.args.args)
                found.append(row(f"<code>{escape(node.name)}({escape(given)}):</code>", depth))
                found += lines(body, node.name, remarks, depth + 1)
            case ast.For(body=body) | ast.If(body=body):
                head = ast.unparse(node).partition("\n")[0]
                found += [row(f"<code>{escape(head)}</code>", depth), *lines(body, name, remarks, depth + 1)]
                if isinstance(node, ast.If) and node.orelse:
                    found += [row("<code>else:</code>", depth), *lines(node.orelse, name, remarks, depth + 1)]
            case _:
                found.append(row(f"<code>{escape(ast.unparse(node))}</code>", depth, remark))
    return found


def comments(text: str) -> dict[int, str]:
    """Line number -> the comment at its end."""
    words = tokenize.generate_tokens(io.StringIO(text).readline)
    return {word.start[0]: word.string.lstrip("# ") for word in words if word.type == tokenize.COMMENT}


def formulas(text: str) -> str:
    """The functions of a Python file as HTML: each with its docstring, its statements as formulas."""
    remarks, found = comments(text), []
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef):
            about = ast.get_docstring(node) or ""
            found.append(f"<h4>{escape(node.name)}</h4><p>{escape(about)}</p>")
            found += lines(node.body, node.name, remarks)
    return "\n".join(found)
