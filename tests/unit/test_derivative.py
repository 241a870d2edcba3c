"""A model that gives its derivative: integrated by the builder, its states known by name, its mistakes one sentence."""
from types import ModuleType, SimpleNamespace

import pytest

from fmus import floats
from fmus.check_model import ModelError, checked_trace
from fmus.integrators import advancing
from fmus.interface import states

MODEL = '''
NAME = "Spring"
DESCRIPTION = "A mass on a spring, and where it began"
VARIABLES = [
    ("force", "input", "N", 0.0, None, None, 1.0, "force on the mass"),
    ("place", "output", "m", None, None, None, 1.0, "place of the mass"),
    ("began", "calculatedParameter", "m", None, None, None, 1.0, "place at the start"),
    ("moving", "output", "1 discrete", None, 0.0, 1.0, 1.0, "1 with a speed above 1 mm/s"),
    ("stiffness", "parameter", "N/m", 4.0, 0.0, None, 1.0, "of the spring, for a mass of 1 kg"),
    ("internal_step", "parameter", "s", 0.01, 1e-6, 1.0, None, "longest internal step"),
]
PRESETS = {}
STATES = ["place", ("speed", "local", "m/s", None, None, None, 1.0, "speed of the mass")]
ORDER = 2


def start(m, u, p):
    return [1.0, 0.0, 1.0]


def derivative(m, t, x, u, p):
    return [x[1], u.force - p.stiffness * x[0]]


def outputs(m, t, x, u, p):
    return {"place": x[0], "began": x[2], "moving": m.where(m.fabs(x[1]) > 1e-3, 1.0, 0.0)}
'''
STATE = '("speed", "local", "m/s", None, None, None, 1.0, "speed of the mass")'
STEP = '    ("internal_step", "parameter", "s", 0.01, 1e-6, 1.0, None, "longest internal step"),\n'


def spring(*changes: tuple[str, str]) -> ModuleType:
    """The model with pieces of its text replaced."""
    text = MODEL
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    model = ModuleType("spring")
    model.__file__ = "spring.py"
    exec(compile(text, "spring.py", "exec"), vars(model))
    return model


@pytest.mark.parametrize("order", [1, 2, 4, 6])
def test_the_builder_integrates_with_the_models_order(order):
    model = spring(("ORDER = 2", f"ORDER = {order}"))
    u, p = SimpleNamespace(force=1.0), SimpleNamespace(stiffness=4.0)
    later = advancing(model)(floats, 0.0, 0.1, [1.0, 0.0, 1.0], u, p, [])
    traced = [float(v) for v in checked_trace(model).advance(0, 0.1, [1, 0, 1], [1], [4, 0.01], []).nonzeros()]
    z = 2j * 0.1  # one step multiplies the deviation by the exponential series up to the order
    term = total = 1.0 + 0j
    for k in range(1, order + 1):
        term *= z / k
        total += term
    assert later[0] == pytest.approx(0.25 + 0.75 * total.real, abs=1e-15 if order < 6 else 1e-9)
    assert later[2] == 1.0 and traced == pytest.approx(later, abs=1e-15)


def test_the_order_is_4_where_none_is_given():
    u, p = SimpleNamespace(force=1.0), SimpleNamespace(stiffness=4.0)
    steps = [advancing(spring(("ORDER = 2", order)))(floats, 0.0, 0.1, [1.0, 0.0, 1.0], u, p, [])
             for order in ("", "ORDER = 4")]
    assert steps[0] == steps[1]


def test_states_are_the_tables_variables_or_local_ones_after_it():
    trace = checked_trace(spring())
    assert trace.derivative is not None and trace.derivative.size1_out(0) == 2
    assert [(v.name, v.value_reference, v.causality, v.unit) for v in states(spring())] == [
        ("place", 1, "output", "m"), ("speed", 6, "local", "m/s")]


MISTAKES = {
    "states without rates": ("def derivative(m, t, x, u, p)", "def advance(m, t, h, x, u, p, c)",
        "there are STATES, but no function derivative; STATES name its rates"),
    "an order that there is not": ("ORDER = 2", "ORDER = 3",
        "ORDER 3 is not allowed; the methods have the orders 1, 2, 4, 6"),
    "an order that is no number": ("ORDER = 2", "ORDER = [2]",
        "ORDER [2] is not allowed; the methods have the orders 1, 2, 4, 6"),
    "a state among the variables": ("VARIABLES = [", f"VARIABLES = [{STATE}, ", "speed: causality 'local' is none of "
        "input, output, calculatedParameter, parameter; a state that is no output is a row of STATES"),
    "no variables": ("PRESETS = {}", "PRESETS = {}; VARIABLES = []",
        "VARIABLES is empty; an FMU has at least one variable (spring.py)"),
    "a state that is overwritten": ("return [x[1], u.force", "x[1] = 0.0; return [x[1], u.force",
        "derivative() changes its arguments; it must leave x, u and p as they are, and return what is new"),
    "an input that is overwritten": ("return [x[1], u.force", "u.force = 0.0; return [x[1], u.force",
        "derivative() changes its arguments; "),
    "chance": ("return [x[1], u.force", "import random; return [random.random(), u.force",
        "derivative() gives something else when it is called again with the same arguments; it must depend on nothing"),
    "a calculated parameter that changes": ('"began": x[2]', '"began": u.force',
        "outputs() computes began from u.force, "
        "which changes; a calculatedParameter depends on parameters and memories only, another is an output"),
    "a table's point that is no number": ("return [x[1], u.force", 'return [m.interpolate(x[1], [0.0, float("nan")], '
        '[1.0, 2.0]), u.force', "derivative() in spring.py, line 22, fails with ValueError: the points of a lookup "),
    "no states": ("STATES = [", "ROWS = [", "STATES is missing or is not a list; beside derivative it has, for each"),
    "a state of no output": ('["place", ', '["plase", ', "STATES names plase, which is no continuous output (did you "
        "mean place?); a state that is no output is a row with the causality 'local'"),
    "a discrete output": ('["place", ', '["moving", ',
        "STATES names moving, which is no continuous output (there are "),
    "a state twice": (STATE, '"place"', "place stands twice in STATES"),
    "a local state of an output's name": (STATE, STATE.replace('"speed"', '"place"'),
        "place stands twice in the table"),
    "a row that is too short": (STATE, '("speed",)', "row 2 of STATES, ('speed',), has 1 entries; a row is (name, "),
    "another causality": (STATE, STATE.replace("local", "output"), "speed: causality 'output' is none of local"),
    "a start of a local state": (STATE, STATE.replace('"m/s", None', '"m/s", 0.0'),
        "speed: inputs and parameters have a start value, outputs have none; this local has 0.0"),
    "a Boolean state": (STATE, STATE.replace('"m/s", None, None, None, 1.0', '"", None, None, None, None'),
        "speed: a continuous state has a unit, and is not discrete"),
    "too few rates": ("return [x[1], u.force", "return [u.force", "derivative() returns 1 rates, STATES has 2 entries, "
        "start() returns 3 states; a rate and an entry belong to each of the first states, and the rest are memories"),
    "too few states": ("return [1.0, 0.0, 1.0]", "return [1.0]",
        "derivative() in spring.py, line 22, fails with IndexError"),
    "a state that its output does not show": ('"place": x[0]', '"place": 2 * x[0]',
        "outputs() gives something else for place than state 0, which STATES names so"),
    "no internal step": (STEP, "", "there is no parameter internal_step; a model without advance is integrated in"),
    "a sample time beside a derivative": ('"internal_step", "parameter"', '"sample_time", "parameter"',
        "there are sample_time and derivative; a discrete law has advance only"),
    "a sample time and internal steps": (STEP, STEP + STEP.replace("internal_step", "sample_time"),
        "sample_time and internal_step exclude each other; a discrete law takes no internal steps"),
    "a sample time of nothing": (STEP, STEP.replace("internal_step", "sample_time").replace("1e-6", "0.0"),
        "sample_time must be a parameter in s with a minimum above 0"),
    "an if in the derivative": ("return [x[1], u", "return [x[1] if x[1] > 0 else 0.0, u",
        "derivative() in spring.py, line 22, decides on a symbol"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_sentence(mistake):
    old, new, told = MISTAKES[mistake]
    with pytest.raises(ModelError) as caught:
        checked_trace(spring((old, new)))
    assert str(caught.value).startswith(f"Spring: {told}"), caught.value
    assert str(caught.value).endswith(".") and "\n" not in str(caught.value)


def test_a_model_has_a_derivative_or_an_advance():
    model = spring(("def derivative(", "def rates("), ("STATES = [", "ROWS = ["))
    with pytest.raises(ModelError, match=r"neither a function derivative\(m, t, x, u, p\) nor advance\(m, t, h, x, "):
        checked_trace(model)
