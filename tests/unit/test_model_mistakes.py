"""A mistake in a model is one sentence that names the model, the place and what is allowed; nothing is built."""
import math
from types import ModuleType

import pytest

from fmus.builder import build
from fmus.check_model import BACKEND, ModelError, checked_trace

MODEL = '''
import math

NAME = "Tank"
DESCRIPTION = "A tank with a valve"
VARIABLES = [
    ("flow", "input", "1/s", 0.5, None, None, None, "inflow"),
    ("open", "input", "", True, None, None, None, "valve open"),
    ("level", "output", "1", None, 0.0, 9.0, 1.0, "level"),
    ("full", "output", "", None, None, None, None, "level above 1"),
    ("rate", "parameter", "1/s", 2.0, 0.0, 5.0, None, "rate of the outflow"),
    ("internal_step", "parameter", "s", 0.01, 0.001, 0.1, None, "longest internal step"),
]
PRESETS = {"slow": {"rate": 1.0}}


def start(m, u, p):
    return [u.flow / p.rate]


def prepare(m, p, h):
    return [m.exp(-p.rate * h)]


def advance(m, t, h, x, u, p, c):
    return [c[0] * x[0] + m.where(u.open, u.flow, 0.0) * h]


def outputs(m, t, x, u, p):
    return {"level": x[0], "full": x[0] > 1.0}
'''
FLOW = '("flow", "input", "1/s", 0.5, None, None, None, "inflow")'
LEVEL = '("level", "output", "1", None, 0.0, 9.0, 1.0, "level")'
RATE = '("rate", "parameter", "1/s", 2.0, 0.0, 5.0, None, "rate of the outflow")'
STEP = '("internal_step", "parameter", "s", 0.01, 0.001, 0.1, None, "longest internal step")'
BACKENDS = "m has " + ", ".join(BACKEND)


def tank(*changes: tuple[str, str]) -> ModuleType:
    """The model with pieces of its text replaced."""
    text = MODEL
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    model = ModuleType("tank")
    model.__file__ = "tank.py"
    exec(compile(text, "tank.py", "exec"), vars(model))
    return model


def test_the_model_itself_has_no_mistake():
    assert checked_trace(tank()).sizes == {"x": 1, "u": 2, "p": 2, "y": 2, "c": 1}


MISTAKES = {
    "a row of another length": (FLOW, '("flow", "input", "1/s", 0.5, "inflow")',
        "row 1 of VARIABLES, ('flow', 'input', '1/s', 0.5, 'inflow'), has 5 entries; "
        "a row is (name, causality, unit, start, min, max, nominal, description)"),
    "a row that is none": (FLOW, '"flow"', "row 1 of VARIABLES, 'flow', is not a tuple; a row is (name, "),
    "an unknown unit": (FLOW, FLOW.replace("1/s", "1/furlong"),
        "flow: in the unit '1/furlong', 'furlong' is not known; a unit is 1 or made of kg, m, s, "),
    "a unit that is none": (FLOW, FLOW.replace('"1/s"', "None"), "flow: the unit None is not text, such as 'ft/s'"),
    "a unit of an unknown kind": (FLOW, FLOW.replace("1/s", "rad/s speed"),
        "flow: in the unit 'rad/s speed', only 'frequency' or 'discrete' may follow"),
    "an unknown causality": (FLOW, FLOW.replace("input", "in"),
        "flow: causality 'in' is none of input, output, calculatedParameter, parameter"),
    "a name twice": (RATE, RATE + ", " + RATE, "rate stands twice in the table; names must differ"),
    "a name that C cannot have": (FLOW, FLOW.replace('"flow"', '"in flow"'),
        "the variable name 'in flow' is not allowed; a name has ASCII letters, digits and _, begins with no digit "
        "and is no Python keyword"),
    "a name that Python cannot have": (RATE, RATE.replace('"rate"', '"lambda"'),
        "the variable name 'lambda' is not allowed"),
    "a model's name that C cannot have": ('"Tank"', '"My tank"', "NAME 'My tank' is not allowed; a name has ASCII"),
    "a description that XML cannot have": ('"inflow"', '"in\\x00flow"', "flow: the description must be one line of"),
    "a description that is none": ('"inflow"', "None", "flow: the description must be one line of text"),
    "a model's description of two lines": ('"A tank with a valve"', '"A tank\\nwith"', "DESCRIPTION must be one line"),
    "no start": (RATE, RATE.replace("2.0", "None"),
        "rate: inputs and parameters have a start value, outputs have none; this parameter has None"),
    "the start of an output": (LEVEL, LEVEL.replace("None, 0.0", "1.0, 0.0"),
        "level: inputs and parameters have a start value, outputs have none; this output has 1.0"),
    "a start out of range": (RATE, RATE.replace("2.0", "6.0"), "rate: start 6.0 is outside [0.0, 5.0]"),
    "a start that is NaN": (RATE, RATE.replace("2.0", "math.nan"), "rate: start nan is not a finite number"),
    "a start that is text": (RATE, RATE.replace("2.0", "'2'"), "rate: start '2' is not a finite number"),
    "a Boolean's start that is a number": ('"", True', '"", 1.0',
        "open: start 1.0 is not True or False, as a Boolean (unit '') has"),
    "a Boolean with a minimum": ('True, None', 'True, 0.0', "open: a Boolean (unit '') has no min, but 0.0 is given"),
    "limits that are crossed": (RATE, RATE.replace("0.0, 5.0", "5.0, 0.0"), "rate: min 5.0 is above max 0.0"),
    "a limit that is infinite": (RATE, RATE.replace("5.0", "math.inf"),
        "rate: max inf is not a finite number; None means that there is none"),
    "a nominal of nothing": (LEVEL, LEVEL.replace("9.0, 1.0", "9.0, 0.0"), "level: nominal 0.0 is not above 0"),
    "an internal step that may be 0": (STEP, STEP.replace("0.001", "0.0"),
        "internal_step must be a parameter in s with a minimum above 0"),
    "a missing table": ("VARIABLES = [", "ROWS = [", "VARIABLES is missing or is not a list of rows; a model has "),
    "a missing function": ("def outputs(", "def results(", "there is no function outputs(m, t, x, u, p)"),
    "too few arguments": ("def advance(m, t, h, x, u, p, c)", "def advance(m, t, h, x, u, p)",
        "advance(m, t, h, x, u, p) has other arguments than advance(m, t, h, x, u, p, c), as which it is called"),
    "too many arguments": ("def start(m, u, p)", "def start(m, t, u, p)",
        "start(m, t, u, p) has other arguments than start(m, u, p), as which it is called"),
    "an output that is not returned": (', "full": x[0] > 1.0', "",
        "outputs() does not return full; it must return every output and calculatedParameter of VARIABLES"),
    "an output that is not declared": (', "full"', ', "empty": False, "full"',
        "outputs() returns empty, which VARIABLES does not declare as output or calculatedParameter"),
    "outputs as a list": ('return {"level": x[0], "full": x[0] > 1.0}', "return [x[0], x[0] > 1.0]",
        "outputs() returns a list, not a dict of names and values"),
    "a preset of an unknown parameter": ('{"rate": 1.0}', '{"rates": 1.0}',
        "the preset slow sets rates, which is no parameter (did you mean rate?)"),
    "a preset of an output": ('{"rate": 1.0}', '{"level": 1.0}', "the preset slow sets level, which is no parameter ("),
    "a preset out of range": ('{"rate": 1.0}', '{"rate": -1.0}',
        "the preset slow sets rate, but the value -1.0 is outside [0.0, 5.0]"),
    "a preset that is no word": ('"slow"', "3", "the preset name 3 is not allowed; it becomes"),
    "a preset that cannot be a file": ('"slow"', '"../slow"', "the preset name '../slow' is not allowed; it becomes"),
    "a state that grows": ("return [c[0] * x[0] + m.where(u.open, u.flow, 0.0) * h]", "return [*x, *x]",
        "advance() returns 2 states, but start() 1; their number is fixed"),
    "a state that is no list": ("return [u.flow / p.rate]", "return u.flow / p.rate",
        "start() returns a float, not a list of numbers"),
    "a state that is NaN": ("return [u.flow / p.rate]", "return [math.nan * u.flow]",
        "start() gives nan for the state 0, from the start values of VARIABLES; a finite number is needed"),
    "an output that is infinite": ('{"level": x[0]', '{"level": math.inf',
        "outputs() gives inf for the output level, from the start values"),
    "a division by zero": ("[u.flow / p.rate]", "[u.flow / (p.rate - 2)]",
        "start() in tank.py, line 18, fails with ZeroDivisionError: "),
    "an if on a symbol": ("return [u.flow / p.rate]", "return [u.flow if u.flow > 0 else 0.0]",
        "start() in tank.py, line 18, decides on a symbol, which has no value yet (if, and, or, not, min, max, "
        "a < b < c); use m.where, m.both, m.either, m.fmin and m.fmax instead"),
    "min of symbols": ("return [u.flow / p.rate]", "return [min(u.flow, p.rate)]",
        "start() in tank.py, line 18, decides on a symbol"),
    "a symbol as an index": ("return [u.flow / p.rate]", "return [(1.0, 2.0)[int(p.rate) - 2]]",
        "start() in tank.py, line 18, uses a symbol as a whole number (int, range or an index); use m.floor"),
    "a function that the backend lacks": ("m.exp(-p.rate * h)", "m.erf(-p.rate * h)",
        f"prepare() in tank.py, line 22, uses m.erf, which the backend lacks; {BACKENDS}"),
    "a function of math": ("m.exp(-p.rate * h)", "math.exp(-p.rate * h)",
        "prepare() gives NaN on symbols, which is what float() and the functions of math make of them; use m, "),
    "an unknown parameter": ("u.flow / p.rate", "u.flow / p.rat",
        "start() in tank.py, line 18, reads p.rat, which is no parameter (did you mean rate?)"),
    "an unknown input": ("u.flow / p.rate", "u.rate / p.rate",
        "start() in tank.py, line 18, reads u.rate, which is no input (there are flow, open)"),
    "a method of floats alone": ("u.flow / p.rate", "u.flow.hex()", "start() gives '0x"),
    "an attribute of floats alone": ("u.flow / p.rate", "u.flow.real",
        "start() in tank.py, line 18, fails with AttributeError: 'SX' object has no attribute 'real'"),
    "a wrong name": ("u.flow / p.rate", "v.flow / p.rate",
        "start() in tank.py, line 18, fails with NameError: name 'v' is not defined"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_sentence(mistake, tmp_path):
    old, new, told = MISTAKES[mistake]
    model = tank((old, new))
    with pytest.raises(ModelError) as caught:
        build(model, "native", tmp_path)
    sentence = str(caught.value)
    assert sentence.startswith(f"{model.NAME}: {told}"), sentence
    assert sentence.endswith(".") and "\n" not in sentence and not sentence.endswith("..")
    assert not list(tmp_path.iterdir())


def test_a_model_without_a_name_is_named_by_its_module(tmp_path):
    with pytest.raises(ModelError, match=r"^tank: NAME is missing or is not a name; a model has NAME, DESCRIPTION"):
        build(tank(('NAME = "Tank"\n', "")), "python", tmp_path)


def test_math_pi_is_no_mistake():
    assert checked_trace(tank(("u.flow / p.rate", "math.pi * u.flow"))).start(1, 1)[0] == pytest.approx(math.pi)
