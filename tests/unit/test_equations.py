"""The formulas that an FMU's page shows, made from its model's Python."""
import ast
import re
from importlib import import_module
from xml.etree import ElementTree

import pytest

from cosim.vehicle.registry import MODELS
from fmus.equations import formula, formulas
from fmus.model_files import model_files


def read(mathml: str) -> str:
    """MathML as one line of text: fractions as (a)/(b), powers as ^, subscripts as _."""
    def text(node) -> str:
        parts = [text(child) for child in node]
        match node.tag:
            case "mfrac":
                return f"({parts[0]})/({parts[1]})"
            case "msup":
                return f"{parts[0]}^({parts[1]})"
            case "msub":
                return f"{parts[0]}_{parts[1]}"
            case "msqrt":
                return f"sqrt({parts[0]})"
            case "mtr":
                return f"{parts[0]} {parts[1]};"
        return (node.text or "") + "".join(parts)
    return text(ElementTree.fromstring(f"<mrow>{mathml}</mrow>"))


@pytest.mark.parametrize("written, shown", [
    ("a - (b + c)", "a−(b+c)"), ("a - b + c", "a−b+c"), ("(a + b) * c", "(a+b)⋅c"), ("a * b + c", "a⋅b+c"),
    ("a / (b * c)", "(a)/(b⋅c)"), ("a / b * c", "(a)/(b)⋅c"), ("-a**2", "−a^(2)"), ("(-a)**2", "(−a)^(2)"),
    ("-k * e", "−k⋅e"), ("a * -b", "a⋅(−b)"), ("a < b <= c", "a<b≤c"), ("(a - b)**2", "(a−b)^(2)"),
    ("(a / b)**2", "((a)/(b))^(2)"), ("(a**b)**c", "(a^(b))^(c)"),
    ("m.sqrt(a + b)", "sqrt(a+b)"), ("m.exp(-a)", "e^(−a)"), ("m.fabs(a)", "|a|"), ("m.sin(a + b)", "sin(a+b)"),
    ("m.where(a > 0, b, c)", "{b if\xa0a>0;c else;"), ("m.both(a < 1, m.either(b, c))", "a<1∧(b∨c)"),
    ("p.k_gamma * u.V", "k_γ⋅V"), ("eta1_dot", "η˙_1"), ("x[3]", "x_3"), ("trim.theta", "θ_trim"),
    ("sum([exp(j) for j in range(N)])", "∑j in range(N)e^(j)"), ("f(*a)", "f(*a)"), ("[a, b]", "(a,b)"),
])
def test_a_formula_says_what_its_line_says(written, shown):
    assert read(formula(ast.parse(written, mode="eval").body)) == shown


def test_statements_become_rows_with_their_remarks():
    page = formulas('def f(m, x):\n    """What f is."""\n    y = x / 2  # (7)\n    y = y\n'
                    '    return SimpleNamespace(a=y, b=2 * y)  # (8)\n')
    rows = re.findall(r"<span><math display=\"inline\">(.*?)</math></span><small>(.*?)</small>", page)
    assert [(read(row), remark) for row, remark in rows] == [("y=(x)/(2)", "(7)"), ("a=y", "(8)"), ("b=2⋅y", "(8)")]
    assert "<h4>f</h4><p>What f is.</p>" in page


@pytest.mark.parametrize("name", MODELS.values())
def test_the_formulas_of_our_models_are_well_formed(name):
    for file in model_files(import_module(name)).values():
        rows = re.findall(r"<math display=\"inline\">.*?</math>", formulas(file.read_text(encoding="utf-8")))
        assert all(ElementTree.fromstring(row) is not None for row in rows)
        assert rows or not re.search("^def ", file.read_text(encoding="utf-8"), re.MULTILINE)
