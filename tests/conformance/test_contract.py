"""Both flavours against the one table of answers (`contract`): each call, in each state, and what it leaves behind."""
import math
import re
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_void_p

import pytest
from contract import FATAL, ROWS, STATES
from talk import (
    DO_STEP_STATUS,
    EMPTY,
    LAST_SUCCESSFUL_TIME,
    MODEL_EXCHANGE,
    NO_ARRAY,
    NO_VARIABLE,
    PENDING_STATUS,
    STEP,
    STOP,
    TERMINATED,
    Library,
    Talk,
    Talk3,
    of,
)

from fmus.native_flavour import HEADERS

IN_THE_NAME = 10  # a byte of what tells whose state it is: of the size or of the package's name

ACTS = {
    ("SetupExperiment", "with start and stop"): lambda f: f.setup(),
    ("SetupExperiment", "from nan"): lambda f: f.setup(math.nan),
    ("SetupExperiment", "from inf"): lambda f: f.setup(math.inf, math.inf),
    ("SetupExperiment", "to before the start"): lambda f: f.setup(2.0, 1.0),
    ("SetupExperiment", "to nan"): lambda f: f.setup(0.0, math.nan),
    ("EnterInitializationMode", ""): lambda f: f.call("EnterInitializationMode"),
    ("ExitInitializationMode", ""): lambda f: f.call("ExitInitializationMode"),
    ("ExitInitializationMode", "after elevator = nan"):
        lambda f: f.after(lambda: f.call("ExitInitializationMode"), elevator=math.nan),
    ("ExitInitializationMode", "without lift"):
        lambda f: f.after(lambda: f.call("ExitInitializationMode"), starts=False, CL_alpha=0.0, CL_elevator=0.0),
    ("Terminate", ""): lambda f: f.call("Terminate"),
    ("Reset", ""): lambda f: f.call("Reset"),
    ("DoStep", "10 ms"): lambda f: f.step(),
    ("DoStep", "0 s"): lambda f: f.step(0.0),
    ("DoStep", "-10 ms"): lambda f: f.step(-STEP),
    ("DoStep", "nan s"): lambda f: f.step(math.nan),
    ("DoStep", "inf s"): lambda f: f.step(math.inf),
    ("DoStep", "from nan"): lambda f: f.step(time=math.nan),
    ("DoStep", "from -inf"): lambda f: f.step(time=-math.inf),
    ("DoStep", "of too many internal steps"): lambda f: f.step(STOP / 2),
    ("DoStep", "up to the stop time"): lambda f: f.step(time=STOP - STEP),
    ("DoStep", "past the stop time"): lambda f: f.step(time=STOP - STEP / 2),
    ("DoStep", "after elevator = nan"): lambda f: f.after(f.step, elevator=math.nan),
    ("DoStep", "out of the model's range"): lambda f: f.after(lambda: f.step(5.0), elevator=-1.5),
    ("CancelStep", ""): lambda f: f.call("CancelStep"),
    ("GetReal", "an output"): lambda f: f.get("Real", "V"),
    ("GetReal", "a calculated parameter"): lambda f: f.get("Real", "theta_trim"),
    ("GetReal", "an input and a parameter"): lambda f: f.get("Real", "elevator", "mass"),
    ("GetReal", "nothing"): lambda f: f.get("Real"),
    ("GetReal", "nothing, without arrays"): lambda f: f.call("GetReal", NO_ARRAY, c_size_t(0), NO_ARRAY),
    ("GetReal", "no variable"): lambda f: f.get("Real", NO_VARIABLE),
    ("GetReal", "a Boolean"): lambda f: f.get("Real", "start_at_trim"),
    ("GetReal", "into a null pointer"): lambda f: f.call("GetReal", of("V"), c_size_t(1), NO_ARRAY),
    ("GetBoolean", "a parameter"): lambda f: f.get("Boolean", "start_at_trim"),
    ("GetBoolean", "a Real"): lambda f: f.get("Boolean", "V"),
    ("GetInteger", "nothing"): lambda f: f.get("Integer"),
    ("GetInteger", "a Real"): lambda f: f.get("Integer", "V"),
    ("GetInteger", "a null pointer"): lambda f: f.call("GetInteger", NO_ARRAY, c_size_t(1), NO_ARRAY),
    ("GetString", "a Real"): lambda f: f.get("String", "V"),
    ("SetReal", "elevator = 0.2"): lambda f: f.set("Real", elevator=0.2),
    ("SetReal", "elevator = nan"): lambda f: f.set("Real", elevator=math.nan),
    ("SetReal", "elevator = inf"): lambda f: f.set("Real", elevator=math.inf),
    ("SetReal", "mass = 310"): lambda f: f.set("Real", mass=310.0),
    ("SetReal", "mass = -1"): lambda f: f.set("Real", mass=-1.0),
    ("SetReal", "mass = nan"): lambda f: f.set("Real", mass=math.nan),
    ("SetReal", "elevator = 0.2, mass = -1"): lambda f: f.set("Real", elevator=0.2, mass=-1.0),
    ("SetReal", "elevator = 0.2, V = 8000"): lambda f: f.set("Real", elevator=0.2, V=8000.0),
    ("SetReal", "V = 8000"): lambda f: f.set("Real", V=8000.0),
    ("SetReal", "theta_trim = 0.1"): lambda f: f.set("Real", theta_trim=0.1),
    ("SetReal", "nothing"): lambda f: f.set("Real"),
    ("SetReal", "no variable"): lambda f: f.call("SetReal", of(NO_VARIABLE), c_size_t(1), EMPTY),
    ("SetReal", "a Boolean"): lambda f: f.set("Real", start_at_trim=1.0),
    ("SetReal", "from a null pointer"): lambda f: f.call("SetReal", of("elevator"), c_size_t(1), NO_ARRAY),
    ("SetBoolean", "start_at_trim = false"): lambda f: f.set("Boolean", start_at_trim=0),
    ("SetBoolean", "a Real"): lambda f: f.set("Boolean", elevator=1),
    ("SetInteger", "a Real"): lambda f: f.set("Integer", elevator=1),
    ("SetString", "a Real"): lambda f: f.call("SetString", of("V"), c_size_t(1), (c_char_p * 1)(b"x")),
    ("GetFMUstate", ""): lambda f: f.call("GetFMUstate", byref(c_void_p())),
    ("SetFMUstate", "its own"): lambda f: f.call("SetFMUstate", f.state()),
    ("SetFMUstate", "none"): lambda f: f.call("SetFMUstate", c_void_p()),
    ("FreeFMUstate", "its own"): lambda f: f.call("FreeFMUstate", byref(f.state())),
    ("FreeFMUstate", "none"): lambda f: f.call("FreeFMUstate", byref(c_void_p())),
    ("SerializeFMUstate", "its own"): lambda f: f.blob()[1],
    ("SerializeFMUstate", "into too few bytes"): lambda f: f.blob(short=1)[1],
    ("DeSerializeFMUstate", "its own"): lambda f: f.unpacked()[1],
    ("DeSerializeFMUstate", "changed bytes"): lambda f: f.unpacked(0)[1],
    ("SetFMUstate", "changed bytes"): lambda f: f.put_back(0),
    ("SetFMUstate", "of another FMU"): lambda f: f.put_back(IN_THE_NAME),
    ("GetDirectionalDerivative", "of an output for an input"): lambda f: f.derivative("thrust", "fuel_ratio"),
    ("GetDirectionalDerivative", "of an output for a parameter"): lambda f: f.derivative("thrust", "mass"),
    ("GetDirectionalDerivative", "of an input"): lambda f: f.derivative("elevator", "fuel_ratio"),
    ("GetDirectionalDerivative", "of a parameter"): lambda f: f.derivative("mass", "fuel_ratio"),
    ("SetRealInputDerivatives", "of an input"):
        lambda f: f.call("SetRealInputDerivatives", of("elevator"), c_size_t(1), (c_int * 1)(1), EMPTY),
    ("GetRealOutputDerivatives", "of an output"):
        lambda f: f.call("GetRealOutputDerivatives", of("V"), c_size_t(1), (c_int * 1)(1), EMPTY),
    ("GetStatus", "of the last step"): lambda f: f.status("GetStatus", DO_STEP_STATUS),
    ("GetStatus", "of a pending step"): lambda f: f.status("GetStatus", PENDING_STATUS),
    ("GetStatus", "of another kind"): lambda f: f.status("GetStatus", TERMINATED),
    ("GetRealStatus", "last successful time"): lambda f: f.status("GetRealStatus", LAST_SUCCESSFUL_TIME),
    ("GetRealStatus", "of another kind"): lambda f: f.status("GetRealStatus", TERMINATED),
    ("GetBooleanStatus", "terminated"): lambda f: f.status("GetBooleanStatus", TERMINATED),
    ("GetBooleanStatus", "of another kind"): lambda f: f.status("GetBooleanStatus", DO_STEP_STATUS),
    ("GetIntegerStatus", "of any kind"): lambda f: f.status("GetIntegerStatus", DO_STEP_STATUS),
    ("GetStringStatus", "of any kind"): lambda f: f.status("GetStringStatus", PENDING_STATUS),
    ("SetDebugLogging", "a listed category"): lambda f: f.log_category("logStatusError"),
    ("SetDebugLogging", "no category of ours"): lambda f: f.log_category("nonsense"),
}
INSTANTIATIONS = {
    "for co-simulation": {}, "another GUID": {"guid": "{wrong}"}, "for model exchange": {"kind": MODEL_EXCHANGE},
    "without a name": {"name": ""},
}
PLACES = [(call, argument, state) for call, argument, *_ in ROWS if call != "Instantiate" for state in STATES]
# Kind of FMU -> (fixture, folder of its library, how it is talked to, the column of its answers).
KINDS = {"native": ("native_fmus", "linux64", Talk, 2), "native-fmi3": ("native_fmi3_fmus", "x86_64-linux", Talk3, 2),
         "python": ("python_fmus", "linux64", Talk, 3)}
NOT_IN_FMI3 = ("CancelStep", "SetRealInputDerivatives", "GetStatus", "GetRealStatus", "GetBooleanStatus",
               "GetIntegerStatus", "GetStringStatus")


def answers(kind):
    """{(call, argument, state): answer} of a kind of FMU; instantiation is in no state."""
    return {(row[0], row[1], state): "-" if kind == "native-fmi3" and row[0] in NOT_IN_FMI3 else answer for row in ROWS
            for state, answer in zip(STATES if row[0] != "Instantiate" else ("",), row[KINDS[kind][3]].split(),
                                     strict=True)}


@pytest.fixture(scope="module", params=KINDS)
def file(request):
    """The plant of a kind, unpacked and loaded."""
    fixture, folder, talk, _ = KINDS[request.param]
    library = Library(request.getfixturevalue(fixture)["AhvPlant"], folder)
    library.answers, library.talk, library.has_status = answers(request.param), talk, talk is Talk
    yield library
    library.close()


@pytest.mark.parametrize("argument", INSTANTIATIONS)
def test_instantiation(file, argument):
    made = file.talk(file, **INSTANTIATIONS[argument])
    assert ("OK" if made.component else "null") == file.answers["Instantiate", argument, ""]
    assert bool(made.said) != bool(made.component)
    made.free()


@pytest.mark.parametrize(("call", "argument", "state"), PLACES)
def test_each_call_in_each_state(file, call, argument, state):
    """The answer of the table; a refused call says why, once, and changes nothing; and the instance lives on."""
    expected = file.answers[call, argument, state]
    if expected == "-":
        return
    fmu = file.talk(file)
    fmu.bring_to(state)
    fmu.before = fmu.everything()
    fmu.said.clear()
    assert ACTS[call, argument](fmu) == expected, fmu.said
    if expected in ("OK", "warning"):
        assert fmu.said == []
    else:
        assert [status for status, _ in fmu.said] == [expected], fmu.said
        assert len(fmu.said[0][1]) > 20
        assert fmu.before is None or fmu.everything() == fmu.before
    if state == "stepping" and call not in ("Terminate", "Reset"):
        assert fmu.call("Terminate") == "OK", fmu.said
    assert fmu.call("Reset") == "OK"
    fmu.bring_to("stepping")
    assert fmu.call("Terminate") == "OK"
    fmu.free()


def test_outputs_can_be_read_before_anything_is_set_and_again_after_a_reset(file):
    """As they are after initialisation with the start values."""
    fmu = file.talk(file)
    first = fmu.everything()
    fmu.bring_to("stepping")
    assert fmu.everything() != first
    assert fmu.call("Reset") == "OK" and fmu.everything() == first
    fmu.set("Real", V_start=8000.0)
    assert fmu.call("Reset") == "OK"
    fmu.bring_to("initialising")
    fmu.call("ExitInitializationMode")
    assert fmu.everything() == first and 7700.0 in first
    fmu.free()


def test_an_input_that_was_refused_is_taken_once_it_is_a_number(file):
    fmu = file.talk(file)
    fmu.bring_to("initialising")
    fmu.set("Real", elevator=math.nan, fuel_ratio=0.3)
    assert fmu.get("Real", "elevator", "fuel_ratio") == "OK"
    assert list(fmu.values) == [pytest.approx(math.radians(12.511)), 0.3]
    assert fmu.call("ExitInitializationMode") != "OK"
    fmu.set("Real", elevator=0.2)
    assert fmu.call("ExitInitializationMode") == "OK"
    fmu.set("Real", elevator=math.inf)
    assert fmu.step() != "OK"
    fmu.set("Real", elevator=0.2)
    assert fmu.step() == "OK"
    fmu.free()


def test_a_step_that_is_refused_is_no_end_of_the_simulation(file):
    """What can be asked afterwards: fmi2Terminated is false, and the last successful time is that of the last step."""
    fmu, time, ended = file.talk(file), c_double(), c_int(7)
    fmu.bring_to("stepping")
    for act in (lambda: fmu.step(0.0), lambda: fmu.step(time=math.nan), lambda: fmu.step(time=STOP)):
        assert act() != "OK"
        if not file.has_status:
            assert (fmu.reached.value, [flag.value for flag in fmu.flags]) == (STEP, [False] * 3)
            continue
        assert fmu.call("GetBooleanStatus", TERMINATED, byref(ended)) == "OK" and ended.value == 0
        assert fmu.call("GetRealStatus", LAST_SUCCESSFUL_TIME, byref(time)) == "OK" and time.value == STEP
    fmu.free()


def test_every_call_of_the_standard_is_in_the_table():
    called = {call for call, *_ in ROWS} | {"FreeInstance", "GetTypesPlatform", "GetVersion", "SerializedFMUstateSize"}
    header = (HEADERS / "fmi2FunctionTypes.h").read_text()
    model_exchange = {"EnterEventMode", "NewDiscreteStates", "EnterContinuousTimeMode", "CompletedIntegratorStep",
                      "SetTime", "SetContinuousStates", "GetDerivatives", "GetEventIndicators", "GetContinuousStates",
                      "GetNominalsOfContinuousStates"}
    assert called | model_exchange == set(re.findall(r"fmi2(\w+)TYPE\b", header))


def test_the_flavours_differ_only_where_the_table_says_why():
    for call, argument, native, python, why in ROWS:
        assert (native == python) == (why is None), (call, argument)
        differing = [(n, p) for n, p in zip(native.split(), python.split()) if n != p]
        if why == FATAL:
            assert all(n in ("discard", "error") and p == "fatal" for n, p in differing), (call, argument)
        else:
            assert not any(p == "fatal" for _, p in differing), (call, argument)
