"""Model exchange through both doors: what each call answers in each state, and what the answers are."""
import math
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t

import pytest
from contract_exchange import ROWS, STATES
from talk import CO_SIMULATION, MODEL_EXCHANGE, NO_ARRAY, STEP, STOP, Library, Talk, Talk3, of

import ahv_plant_fmu.model as plant
from fmus import floats

KINDS = {"fmi2": ("native_fmus", "linux64", Talk), "fmi3": ("native_fmi3_fmus", "x86_64-linux", Talk3)}
N = len(plant.STATES)


class Exchanging:
    """An instance for model exchange; `said` has its messages."""

    def __init__(self, file, kind=MODEL_EXCHANGE):
        self.talk, self.fmi3 = file.talk(file, kind=kind), file.talk is Talk3
        self.call, self.said, self.free = self.talk.call, self.talk.said, self.talk.free

    def bring_to(self, state):
        place = STATES.index(state)
        self.talk.bring_to("initialising" if place else "instantiated")
        done = ["ExitInitializationMode", "EnterContinuousTimeMode", "Terminate"]
        for call in done[:max(0, place - 1)]:
            assert self.call(call) == "OK", self.said

    def time(self, t):
        return self.call("SetTime", c_double(t))

    def put(self, x, n=None):
        return self.call("SetContinuousStates", (c_double * len(x))(*x), c_size_t(len(x) if n is None else n))

    def ask(self, call, n=N):
        self.values = (c_double * 16)()
        answer = self.call(call, self.values, c_size_t(n))
        self.values = self.values[:n]
        return answer

    def states(self):
        assert self.ask("GetContinuousStates") == "OK", self.said
        return self.values

    def discrete(self, give=True):
        self.flags, self.next = [c_bool(True) for _ in range(5)], c_double(7)
        if not self.fmi3:
            return self.call("NewDiscreteStates", (c_int * 8)() if give else None)
        return self.call("NewDiscreteStates", *map(byref, self.flags), byref(self.next) if give else None)

    def completed(self, give=True):
        self.event, ends = (c_bool(True), c_bool(True)) if self.fmi3 else (c_int(7), c_int(7))
        return self.call("CompletedIntegratorStep", c_bool(True) if self.fmi3 else 1, byref(self.event),
                         byref(ends) if give else None)

    def late(self):
        self.time(STOP * 1.01)
        self.said.clear()
        return self.completed()


def array(call, n=N):
    return lambda f: f.ask(call, n)


ACTS = {
    ("EnterInitializationMode", ""): lambda f: f.call("EnterInitializationMode"),
    ("NewDiscreteStates", ""): lambda f: f.discrete(),
    ("NewDiscreteStates", "without a place for the answer"): lambda f: f.discrete(give=False),
    ("CompletedIntegratorStep", ""): lambda f: f.completed(),
    ("CompletedIntegratorStep", "past the stop time"): lambda f: f.late(),
    ("CompletedIntegratorStep", "without a place for the answer"): lambda f: f.completed(give=False),
    ("DoStep", "10 ms"): lambda f: f.talk.step(),
    ("SetTime", "1 s"): lambda f: f.time(1.0),
    ("SetTime", "nan"): lambda f: f.time(math.nan),
    ("SetContinuousStates", "its own"): lambda f: f.put(f.states()),
    ("SetContinuousStates", "one too few"): lambda f: f.put(f.states(), N - 1),
    ("SetContinuousStates", "a null pointer"): lambda f: f.call("SetContinuousStates", NO_ARRAY, c_size_t(N)),
    ("GetContinuousStates", ""): array("GetContinuousStates"),
    ("GetContinuousStates", "one too few"): array("GetContinuousStates", N - 1),
    ("GetDerivatives", ""): array("GetDerivatives"),
    ("GetDerivatives", "into a null pointer"): lambda f: f.call("GetDerivatives", NO_ARRAY, c_size_t(N)),
    ("GetNominalsOfContinuousStates", ""): array("GetNominalsOfContinuousStates"),
    ("GetNominalsOfContinuousStates", "one too many"): array("GetNominalsOfContinuousStates", N + 1),
    ("GetEventIndicators", "none"): array("GetEventIndicators", 0),
    ("GetEventIndicators", "one"): array("GetEventIndicators", 1),
    ("GetReal", "a derivative"): lambda f: f.talk.get("Real", "der(V)"),
    ("SetReal", "a derivative"): lambda f: f.talk.set("Real", **{"der(V)": 1.0}),
    ("SetReal", "elevator = 0.2"): lambda f: f.talk.set("Real", elevator=0.2),
    ("SetReal", "mass = 310"): lambda f: f.talk.set("Real", mass=310.0),
    ("GetDirectionalDerivative", "of a derivative for an input"): lambda f: f.talk.derivative("der(V)", "fuel_ratio"),
    ("GetDirectionalDerivative", "of a derivative for a state"): lambda f: f.talk.derivative("der(V)", "V"),
    ("GetDirectionalDerivative", "of a derivative for a parameter"): lambda f: f.talk.derivative("der(V)", "mass"),
    ("GetDirectionalDerivative", "of a derivative for a derivative"): lambda f: f.talk.derivative("der(V)", "der(h)"),
}


@pytest.fixture(scope="module", params=KINDS)
def file(request):
    fixture, folder, talk = KINDS[request.param]
    library = Library(request.getfixturevalue(fixture)["AhvPlant"], folder)
    library.talk = talk
    yield library
    library.close()


@pytest.fixture
def fmu(file):
    made = Exchanging(file)
    yield made
    made.free()


@pytest.fixture
def solved(fmu):
    """In continuous time, where a solver would have it."""
    fmu.bring_to("in continuous time")
    return fmu


@pytest.mark.parametrize(("call", "argument", "state", "expected"),
                         [(call, argument, state, answer) for call, argument, all_answers in ROWS
                          for state, answer in zip(STATES, all_answers.split(), strict=True)])
def test_each_call_in_each_state(fmu, call, argument, state, expected):
    """A refused call says why, once, and changes nothing."""
    fmu.bring_to(state)
    before = fmu.talk.everything()
    fmu.said.clear()
    assert ACTS.get((call, argument), lambda f: f.call(call))(fmu) == expected, fmu.said
    assert [status for status, _ in fmu.said] == ([] if expected == "OK" else [expected]), fmu.said
    if expected != "OK":
        assert len(fmu.said[0][1]) > 20
        assert fmu.talk.everything() == before
    assert fmu.call("Reset") == "OK"
    fmu.bring_to("in continuous time")


@pytest.mark.parametrize("call", ["EnterEventMode", "NewDiscreteStates", "EnterContinuousTimeMode",
                                  "CompletedIntegratorStep", "SetTime", "SetContinuousStates", "GetContinuousStates",
                                  "GetDerivatives", "GetNominalsOfContinuousStates", "GetEventIndicators"])
@pytest.mark.parametrize("state", ["instantiated", "stepping"])
def test_an_instance_for_co_simulation_refuses_them(file, call, state):
    fmu = Exchanging(file, CO_SIMULATION)
    fmu.talk.bring_to(state)
    act = {"SetTime": lambda: fmu.time(1.0), "NewDiscreteStates": fmu.discrete,
           "CompletedIntegratorStep": fmu.completed, "SetContinuousStates": lambda: fmu.put([0.0] * N)}.get(call)
    answer = act() if act else fmu.ask(call) if call.startswith("Get") else fmu.call(call)
    assert (answer, "for co-simulation, not for model exchange" in fmu.said[-1][1]) == ("error", True), fmu.said
    fmu.free()


def test_rates_are_the_models_own(solved):
    """To the last digits: the same operations in C and in Python."""
    parameters = {name: start for name, kind, _, start, *_ in plant.VARIABLES if kind == "parameter"}
    inputs = {name: start for name, kind, _, start, *_ in plant.VARIABLES if kind == "input"}
    u, p = type("u", (), {**inputs, "elevator": 0.1}), type("p", (), parameters)
    x = [7800.0, 86000.0, 0.01, 0.03, 0.02, 0.5, 1.0, -0.2, 2.0]
    assert solved.talk.set("Real", elevator=0.1) == "OK"
    assert solved.put(x) == "OK" and solved.states() == x
    assert solved.ask("GetDerivatives") == "OK"
    assert solved.values == pytest.approx(plant.derivative(floats, 0.0, [*x, 0.0, 0.0, 0.0, 0.0], u, p), rel=1e-12)
    named = [f"der({name})" for name in plant.STATES]
    assert solved.talk.get("Real", *named) == "OK" and list(solved.talk.values) == solved.values
    assert solved.talk.get("Real", *plant.STATES) == "OK" and list(solved.talk.values) == x


def test_nominals_are_those_of_the_table(fmu):
    rows = {row[0]: row for row in plant.VARIABLES}
    assert fmu.ask("GetNominalsOfContinuousStates") == "OK"
    assert fmu.values == [rows[name][6] for name in plant.STATES]


@pytest.mark.parametrize(("name", "value", "text"), [
    ("V", 2999.0, "V = 2999 ft/s is below its minimum 3000 ft/s at t = 2 s"),
    ("gamma", 2.0, "gamma = 114.592 deg is above its maximum 90 deg at t = 2 s"),
    ("Q", math.nan, "Q = nan is not a finite number at t = 2 s"),
    ("eta1", math.inf, "eta1 = inf is not a finite number at t = 2 s")])
def test_a_state_outside_the_models_range_is_never_silent(solved, name, value, text):
    good = solved.states()
    bad = [value if state == name else x for state, x in zip(plant.STATES, good)]
    assert solved.time(2.0) == "OK" and solved.put(bad) == "OK"
    for act in (lambda: solved.ask("GetDerivatives"), lambda: solved.talk.get("Real", "thrust"),
                lambda: solved.talk.get("Real", "der(V)")):
        solved.said.clear()
        assert act() == "discard" and text in solved.said[0][1] and len(solved.said) == 1
    assert solved.put(good) == "OK" and solved.ask("GetDerivatives") == "OK"


def test_an_input_that_is_no_number_is_never_silent(solved):
    assert solved.talk.set("Real", elevator=math.nan) == "discard"
    solved.said.clear()
    assert solved.ask("GetDerivatives") == "discard"
    assert "elevator = nan is not a finite number at t = 0 s" in solved.said[0][1]
    assert solved.talk.set("Real", elevator=0.2) == "OK" and solved.ask("GetDerivatives") == "OK"


def test_there_are_no_events(solved):
    assert solved.completed() == "OK" and not solved.event.value
    assert solved.call("EnterEventMode") == "OK" and solved.discrete() == "OK"
    if solved.fmi3:
        assert [flag.value for flag in solved.flags] == [False] * 5
        assert solved.call("EvaluateDiscreteStates") == "OK"


def test_a_state_saved_is_for_the_same_kind_of_instance(file, solved):
    stepping = file.talk(file)
    stepping.bring_to("stepping")
    assert solved.time(3.0) == "OK"
    saved, values = solved.talk.state(), solved.states()
    assert solved.time(4.0) == "OK" and solved.put([x + 1 for x in values]) == "OK"
    assert solved.call("SetFMUstate", saved) == "OK" and solved.states() == values
    assert stepping.call("SetFMUstate", saved) == "error"
    assert solved.call("SetFMUstate", stepping.state()) == "error"
    stepping.free()


def test_a_derivative_is_read_in_co_simulation_as_well(file):
    """Of the state that the last step reached."""
    stepping, solved = file.talk(file), Exchanging(file)
    stepping.bring_to("stepping")
    assert stepping.get("Real", *plant.STATES) == "OK"
    x = list(stepping.values)
    solved.bring_to("in continuous time")
    assert solved.time(STEP) == "OK" and solved.put(x) == "OK" and solved.ask("GetDerivatives") == "OK"
    assert stepping.get("Real", *(f"der({name})" for name in plant.STATES)) == "OK"
    assert list(stepping.values) == solved.values and any(solved.values)
    stepping.free(), solved.free()


def test_time_is_a_variable(solved):
    assert solved.time(2.5) == "OK"
    assert solved.talk.get("Real", "time") == "OK" and list(solved.talk.values) == [2.5]
    assert solved.talk.set("Real", time=1.0) == "error" and "is the time and may not be set" in solved.said[-1][1]


def test_models_without_derivatives_are_for_co_simulation_only(native_fmi3_fmus, native_fmus):
    for fmus, folder, talk in ((native_fmus, "linux64", Talk), (native_fmi3_fmus, "x86_64-linux", Talk3)):
        library = Library(fmus["AhvScenario"], folder, "AhvScenario")
        made = talk(library, kind=MODEL_EXCHANGE)
        assert made.component is None and "AhvScenario is for co-simulation only" in made.said[0][1]
        library.close()


def test_log_categories_are_chosen_in_fmi_3_as_in_fmi_2(fmu):
    assert fmu.talk.log_category("logStatusDiscard") == "OK"
    assert fmu.call("Terminate") == "error" and fmu.said == []
    assert fmu.call("SetDebugLogging", c_bool(True) if fmu.fmi3 else 1, c_size_t(1), (c_char_p * 1)(None)) == "error"
    assert of("V")[0] == [row[0] for row in plant.VARIABLES].index("V")
