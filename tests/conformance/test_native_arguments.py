"""A native FMU called as C calls it, with arguments that a careful importer would not give: a status, never a crash."""
import ctypes
import math
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

import pytest
from fmpy.fmi2 import fmi2CallbackFunctions
from test_native_refusals import DISCARD, ERROR, Talking

from fmus import native_flavour
from fmus.builder import build

OK = 0
CO_SIMULATION = 1
STEP_STATUS, PENDING, LAST_TIME, TERMINATED = range(4)  # fmi2StatusKind

# Arguments after the instance: p a pointer, n a size, d a number, i an integer.
CALLS = {
    "fmi2SetDebugLogging": "inp", "fmi2SetupExperiment": "iddid", "fmi2EnterInitializationMode": "",
    "fmi2ExitInitializationMode": "", "fmi2Terminate": "", "fmi2Reset": "",
    **{f"fmi2{verb}{kind}": "pnp" for verb in ("Get", "Set") for kind in ("Real", "Integer", "Boolean", "String")},
    "fmi2GetFMUstate": "p", "fmi2SetFMUstate": "p", "fmi2FreeFMUstate": "p", "fmi2SerializedFMUstateSize": "pp",
    "fmi2SerializeFMUstate": "ppn", "fmi2DeSerializeFMUstate": "pnp", "fmi2GetDirectionalDerivative": "pnpnpp",
    "fmi2SetRealInputDerivatives": "pnpp", "fmi2GetRealOutputDerivatives": "pnpp", "fmi2DoStep": "ddi",
    "fmi2CancelStep": "", "fmi2EnterEventMode": "", "fmi2NewDiscreteStates": "p", "fmi2EnterContinuousTimeMode": "",
    "fmi2CompletedIntegratorStep": "ipp", "fmi2SetTime": "d", "fmi2SetContinuousStates": "pn",
    **dict.fromkeys(["fmi2GetDerivatives", "fmi2GetEventIndicators", "fmi2GetContinuousStates",
                     "fmi2GetNominalsOfContinuousStates"], "pn"),
    **dict.fromkeys(["fmi2GetStatus", "fmi2GetRealStatus", "fmi2GetIntegerStatus", "fmi2GetBooleanStatus",
                     "fmi2GetStringStatus"], "ip"),
}
TYPES = {"p": c_void_p, "n": c_size_t, "d": c_double, "i": c_int}
NOTHING = {"p": None, "n": 0, "d": 0.0, "i": 0}


class Raw:
    """The functions of a loaded FMU without fmpy's care."""

    def __init__(self, member: Talking):
        self.member, self.library = member, ctypes.CDLL(member.slave.dll._name)

    def __call__(self, name, *arguments, component=True):
        function = getattr(self.library, name)
        function.restype, function.argtypes = c_int, [c_void_p, *(TYPES[letter] for letter in CALLS[name])]
        self.member.said.clear()
        return function(self.member.slave.component if component is True else component, *arguments)

    def reference(self, *names):
        return (c_uint * len(names))(*self.member.references(names))


@pytest.fixture(scope="module")
def file(native_fmus):
    return native_fmus["AhvPlant"]


@pytest.fixture
def raw(file):
    with Talking(file) as member:
        yield Raw(member)


@pytest.fixture
def flying(raw):
    raw.member.begin()
    raw.member.shut()
    return raw


@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_instance_is_an_error(raw, name):
    arguments = [NOTHING[letter] for letter in CALLS[name]]
    assert raw(name, *arguments, component=None) == ERROR
    assert raw(name, *arguments, component=ctypes.cast(ctypes.create_string_buffer(4096), c_void_p)) == ERROR
    assert raw.member.said == []


@pytest.mark.parametrize("name,type", [(f"fmi2{verb}{kind}", type) for verb in ("Get", "Set")
                                       for kind, type in (("Real", c_double), ("Boolean", c_int))])
def test_announced_arrays_must_be_there(raw, name, type):
    variable = raw.reference("start_at_trim" if type is c_int else "V_start")
    value = (type * 1)(1.0 if type is c_double else 1)
    assert raw(name, None, 0, None) == OK and raw.member.said == []
    for arrays in ((None, 1, value), (variable, 1, None)):
        assert raw(name, *arrays) == ERROR
        assert "1 variables were announced, but no array of them was given" in raw.member.said[0][2]


@pytest.mark.parametrize("name", ["fmi2GetInteger", "fmi2SetString"])
def test_no_integers_or_strings_can_be_read_or_set_and_none_need_be(raw, name):
    assert raw(name, None, 0, None) == OK
    assert raw(name, None, 1, None) == ERROR and "announced" in raw.member.said[0][2]


def test_derivatives_need_their_arrays(flying):
    inputs, outputs, numbers = flying.reference("elevator"), flying.reference("Q"), (c_double * 1)(1.0)
    for without in range(4):
        known, seed, unknown, found = (None if i == without else array
                                       for i, array in enumerate((inputs, numbers, outputs, (c_double * 1)())))
        assert flying("fmi2GetDirectionalDerivative", unknown, 1, known, 1, seed, found) == ERROR
    for wrong in ((flying.reference("start_at_trim"), inputs), (outputs, flying.reference("start_at_trim"))):
        assert flying("fmi2GetDirectionalDerivative", wrong[0], 1, wrong[1], 1, numbers, (c_double * 1)()) == ERROR
        assert "is no Real" in flying.member.said[0][2]


def test_a_derivative_of_several_inputs_is_the_sum(flying):
    outputs, found = flying.reference("Q", "thrust"), (c_double * 2)()

    def slopes(*seeds):
        known = flying.reference(*("elevator", "fuel_ratio", "elevator")[:len(seeds)])
        seed = (c_double * 3)(*seeds)
        assert flying("fmi2GetDirectionalDerivative", outputs, 2, known, len(seeds), seed, found) == OK
        return list(found)

    alone, other = slopes(1.0), slopes(0.0, 1.0)
    assert other[1] != 0
    assert slopes(1.0, 2.0, 3.0) == pytest.approx([4 * a + 2 * b for a, b in zip(alone, other)], rel=1e-12)


def test_before_the_end_of_initialisation_a_derivative_by_a_parameter_exists(raw):
    raw.member.begin()
    found, seed = (c_double * 2)(), (c_double * 1)(1.0)
    unknown, known = raw.reference("V", "h"), raw.reference("V_start")
    assert raw("fmi2GetDirectionalDerivative", unknown, 2, known, 1, seed, found) == OK
    assert list(found) == [1.0, 0.0]


def test_booleans_are_read_as_set(raw):
    variable, found = raw.reference("start_at_trim"), (c_int * 1)()
    for value in (0, 1, 7):
        assert raw("fmi2SetBoolean", variable, 1, (c_int * 1)(value)) == OK
        assert raw("fmi2GetBoolean", variable, 1, found) == OK and found[0] == (value != 0)


@pytest.mark.parametrize("name,kind,type", [
    ("fmi2GetStatus", STEP_STATUS, c_int), ("fmi2GetRealStatus", LAST_TIME, c_double),
    ("fmi2GetBooleanStatus", TERMINATED, c_int)])
def test_a_status_is_of_its_own_kind(flying, name, kind, type):
    value = type(99)
    for asked in range(4):
        assert flying(name, asked, byref(value)) == (OK if asked == kind else DISCARD)
        assert asked == kind or "has no such status" in flying.member.said[0][2]
    assert value.value == 0  # no step yet, at t = 0, not ended
    assert flying(name, kind, None) == DISCARD
    for none in ("fmi2GetIntegerStatus", "fmi2GetStringStatus"):
        assert flying(none, PENDING, byref(value)) == DISCARD


def test_the_status_is_the_last_steps(flying):
    status, ended, time = c_int(99), c_int(99), c_double(99)

    def step(*arguments):
        result = flying("fmi2DoStep", *arguments, 1)
        assert flying("fmi2GetStatus", STEP_STATUS, byref(status)) == OK and status.value == result
        assert flying("fmi2GetBooleanStatus", TERMINATED, byref(ended)) == OK
        assert flying("fmi2GetRealStatus", LAST_TIME, byref(time)) == OK
        return result, ended.value, time.value

    assert step(0.0, 0.01) == (OK, 0, 0.01)
    assert step(0.01, -0.01) == (DISCARD, 0, 0.01)       # what is wrong is the argument, the model has not ended
    assert step(math.nan, 0.01) == (DISCARD, 0, 0.01)
    assert step(math.inf, 0.01) == (DISCARD, 0, 0.01)
    assert step(0.01, 1e300) == (DISCARD, 0, 0.01)
    assert flying("fmi2SetReal", flying.reference("elevator"), 1, (c_double * 1)(math.nan)) == DISCARD
    assert step(0.01, 0.01) == (DISCARD, 0, 0.01)
    assert flying("fmi2SetReal", flying.reference("elevator"), 1, (c_double * 1)(0.2)) == OK
    assert step(0.01, 0.02) == (OK, 0, 0.03)


def test_an_input_is_given_back_after_its_refusal_ends(flying):
    """A step with another input refused: each one is looked at."""
    for name in flying.member.names("input"):
        variable = flying.reference(name)
        assert flying("fmi2SetReal", variable, 1, (c_double * 1)(-math.inf)) == DISCARD
        assert flying("fmi2DoStep", 0.0, 0.01, 1) == DISCARD
        assert f"{name} = -inf is not a finite number at t = 0 s" in flying.member.said[0][2]
        assert flying("fmi2SetReal", variable, 1, (c_double * 1)(*flying.member.get(name))) == OK
    assert flying("fmi2DoStep", 0.0, 0.01, 1) == OK


def instantiated(raw, name=b"one", kind=CO_SIMULATION, guid=None, callbacks=None):
    function = raw.library.fmi2Instantiate
    function.restype = c_void_p
    function.argtypes = [c_char_p, c_int, c_char_p, c_char_p, POINTER(fmi2CallbackFunctions), c_int, c_int]
    raw.member.said.clear()
    return function(name, kind, guid, None, callbacks, 0, 0)


def test_an_instance_needs_a_name_its_kind_its_guid_and_memory(raw):
    callbacks, guid = raw.member.callbacks, raw.member.description.guid.encode()
    for text, arguments in {
            "needs a name": {"name": None}, "an instance of AhvPlant needs": {"name": b""},
            "is for model exchange or co-simulation, not type 2": {"kind": 2},
            "the GUID NULL is not": {"guid": None}}.items():
        assert instantiated(raw, **{"guid": guid, "callbacks": callbacks, **arguments}) is None
        assert raw.member.said[0][0] == ERROR and text in raw.member.said[0][2] and len(raw.member.said) == 1
    for missing in ("allocateMemory", "freeMemory"):
        without = fmi2CallbackFunctions.from_buffer_copy(callbacks)
        setattr(without, missing, type(getattr(without, missing))())
        assert instantiated(raw, guid=guid, callbacks=without) is None
        assert "needs the callbacks" in raw.member.said[0][2]
    assert instantiated(raw, guid=guid) is None and raw.member.said == []
    silent = fmi2CallbackFunctions.from_buffer_copy(callbacks)
    silent.logger = type(silent.logger)()
    assert instantiated(raw, name=None, guid=guid, callbacks=silent) is None and raw.member.said == []
    empty = fmi2CallbackFunctions.from_buffer_copy(callbacks)
    empty.allocateMemory = type(empty.allocateMemory)(lambda *_: None)
    assert instantiated(raw, guid=guid, callbacks=empty) is None
    assert "no memory for an instance" in raw.member.said[0][2]
    found = instantiated(raw, guid=guid, callbacks=callbacks)
    assert found and raw.member.said == []
    raw.library.fmi2FreeInstance.argtypes = [c_void_p]
    raw.library.fmi2FreeInstance(found)
    raw.library.fmi2FreeInstance(None)


@pytest.mark.parametrize("start,defined,stop,status", [
    (0.0, 1, 0.0, OK), (1.0, 1, 0.5, ERROR), (0.0, 1, math.nan, ERROR), (1.0, 0, 0.5, OK), (math.nan, 0, 1.0, ERROR),
    (-math.inf, 0, 1.0, ERROR), (5.0, 1, 6.0, OK)])
def test_the_experiment_begins_at_a_number_and_ends_after_it(raw, start, defined, stop, status):
    assert raw("fmi2SetupExperiment", 0, 0.0, start, defined, stop) == status
    assert bool(raw.member.said) == bool(status)
    time = c_double()
    assert raw("fmi2GetRealStatus", LAST_TIME, byref(time)) == OK and time.value == (0.0 if status else start)


def test_the_stop_time_leaves_room_for_the_rounding_of_a_step(raw):
    assert raw("fmi2SetupExperiment", 0, 0.0, 1.0, 1, 1.02) == OK
    raw.member.slave.enterInitializationMode()
    raw.member.shut()
    assert raw("fmi2DoStep", 1.0, 0.01, 1) == OK
    assert raw("fmi2DoStep", 1.01, 0.01 * (1 + 3e-6), 1) == ERROR
    assert raw("fmi2DoStep", 1.01, 0.01 * (1 + 5e-7), 1) == OK


def test_a_state_is_kept_in_what_the_importer_gave(flying):
    state, size = c_void_p(), c_size_t()
    assert flying("fmi2GetFMUstate", None) == ERROR and "the state given is none" in flying.member.said[0][2]
    assert flying("fmi2GetFMUstate", byref(state)) == OK
    place = state.value
    assert flying("fmi2DoStep", 0.0, 0.01, 1) == OK
    assert flying("fmi2GetFMUstate", byref(state)) == OK and state.value == place  # overwritten, not made anew
    foreign = c_void_p(ctypes.addressof(memory := ctypes.create_string_buffer(4096)))
    for call in (("fmi2GetFMUstate", byref(foreign)), ("fmi2FreeFMUstate", byref(foreign)), ("fmi2SetFMUstate", None),
                 ("fmi2SetFMUstate", memory), ("fmi2SerializedFMUstateSize", state, None),
                 ("fmi2SerializedFMUstateSize", None, byref(size))):
        assert flying(*call) == ERROR and "the state given is none" in flying.member.said[0][2]
    assert flying("fmi2SerializedFMUstateSize", state, byref(size)) == OK
    blob = ctypes.create_string_buffer(size.value)
    assert flying("fmi2SerializeFMUstate", state, blob, size.value - 1) == ERROR
    assert f"takes {size.value} bytes, not {size.value - 1}" in flying.member.said[0][2]
    assert flying("fmi2SerializeFMUstate", state, None, size.value) == ERROR
    assert flying("fmi2SerializeFMUstate", None, blob, size.value) == ERROR
    assert flying("fmi2SerializeFMUstate", state, blob, size.value) == OK
    for call in ((None, size.value, byref(state)), (blob, size.value, None), (blob, size.value, byref(foreign))):
        assert flying("fmi2DeSerializeFMUstate", *call) == ERROR
    later = flying.member.fly(1, 5)
    assert flying("fmi2DeSerializeFMUstate", blob, size.value, byref(state)) == OK and state.value == place
    assert flying("fmi2SetFMUstate", state) == OK
    assert flying.member.fly(1, 5) == later
    assert flying("fmi2FreeFMUstate", byref(state)) == OK and state.value is None
    assert flying("fmi2FreeFMUstate", byref(state)) == flying("fmi2FreeFMUstate", None) == OK


def test_log_categories_are_chosen_one_by_one(raw):
    names = (c_char_p * 2)(b"logStatusError", b"logStatusDiscard")

    def said(count, on=1, categories=names):
        assert raw("fmi2SetDebugLogging", on, count, categories) == OK
        heard = []
        for name, value, status in (("mass", math.nan, DISCARD), ("V", 1.0, ERROR)):
            assert raw("fmi2SetReal", raw.reference(name), 1, (c_double * 1)(value)) == status
            heard.append(bool(raw.member.said))
        return heard

    assert said(1) == [False, True]
    assert said(2) == [True, True]
    assert said(1, categories=(c_char_p * 1)(b"logStatusWarning")) == [False, False]
    assert said(0, categories=None) == [True, True]
    assert said(1, on=0) == [True, True]  # what is refused is told in any case
    assert raw("fmi2SetDebugLogging", 1, 1, None) == ERROR
    assert raw("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)(None)) == ERROR
    assert "no log category NULL" in raw.member.said[0][2]


@pytest.mark.parametrize("name,text", [("fmi2CancelStep", "there is no step to cancel"),
                                       ("fmi2SetRealInputDerivatives", "does not interpolate inputs"),
                                       ("fmi2GetRealOutputDerivatives", "no output derivatives in time")])
def test_what_is_not_promised_is_refused(flying, name, text):
    assert flying(name, *(NOTHING[letter] for letter in CALLS[name])) == ERROR
    assert text in flying.member.said[0][2]


def test_platform_and_version(raw):
    for name, text in (("fmi2GetVersion", b"2.0"), ("fmi2GetTypesPlatform", b"default")):
        function = getattr(raw.library, name)
        function.restype = c_char_p
        assert function() == text


def test_reset_forgets_the_stop_time(raw):
    assert raw("fmi2SetupExperiment", 0, 0.0, 0.0, 1, 0.01) == OK
    assert raw("fmi2Reset") == OK
    raw.member.slave.enterInitializationMode()
    raw.member.shut()
    assert raw("fmi2DoStep", 0.0, 0.02, 1) == OK


def test_without_memory_there_is_no_state(raw):
    callbacks = fmi2CallbackFunctions.from_buffer_copy(raw.member.callbacks)
    allocate = raw.member.callbacks.allocateMemory
    calls = iter([allocate])  # the instance's memory, and no more
    callbacks.allocateMemory = type(allocate)(lambda n, size: next(calls, lambda *_: None)(n, size))
    component = instantiated(raw, guid=raw.member.description.guid.encode(), callbacks=callbacks)
    state = c_void_p()
    assert raw("fmi2GetFMUstate", byref(state), component=component) == ERROR
    assert "no memory for a state" in raw.member.said[0][2] and state.value is None
    raw.library.fmi2FreeInstance.argtypes = [c_void_p]
    raw.library.fmi2FreeInstance(component)


GROWING = '''"""A state that outgrows what a double can hold, behind an output that does not."""
NAME = "Growing"
DESCRIPTION = "A state that grows by a factor in each step"
VARIABLES = [
    ("shown", "output", "1", None, None, None, 1.0, "the state, but no more than 1"),
    ("factor", "parameter", "1", 1e200, None, None, None, "growth in a step"),
    ("first", "parameter", "1", 1.0, None, None, None, "the square root of the first state"),
]
PRESETS = {}


def start(m, u, p):
    return [0.0, p.first * p.first]


def advance(m, t, h, x, u, p, c):
    return [x[0], x[1] * p.factor]


def outputs(m, t, x, u, p):
    return {"shown": m.fmin(x[1], 1.0)}
'''


@pytest.fixture
def growing(tmp_path, monkeypatch):
    (tmp_path / "growing.py").write_text(GROWING)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(native_flavour, "PLATFORMS", {"x86_64-linux": native_flavour.PLATFORMS["x86_64-linux"]})
    with Talking(build("growing", "native", tmp_path / "dist")) as member:
        yield Raw(member)
    del sys.modules["growing"]


def test_a_state_that_is_no_number_is_never_taken(growing):
    assert growing("fmi2SetReal", growing.reference("first"), 1, (c_double * 1)(1e200)) == OK
    assert growing("fmi2GetReal", growing.reference("shown"), 1, (c_double * 1)()) == ERROR
    assert "Growing cannot start: an internal state is not a finite number" in growing.member.said[0][2]
    assert growing("fmi2SetReal", growing.reference("first"), 1, (c_double * 1)(1.0)) == OK
    growing.member.begin()
    growing.member.shut()
    assert growing("fmi2DoStep", 0.0, 0.5, 1) == OK
    assert growing("fmi2DoStep", 0.5, 0.5, 1) == DISCARD
    assert "an internal state is not a finite number at t = 1 s" in growing.member.said[0][2]
    ended, time = c_int(), c_double()
    assert growing("fmi2GetBooleanStatus", TERMINATED, byref(ended)) == OK and ended.value == 0
    assert growing("fmi2GetRealStatus", LAST_TIME, byref(time)) == OK and time.value == 0.5
    assert growing.member.get("shown") == [1.0]
