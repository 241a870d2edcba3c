"""An instance of the plant called raw, through either version of FMI: what the tests of the contract talk to."""
import ctypes
import shutil
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from types import MappingProxyType

import fmpy
from contract import STATES

import ahv_plant_fmu.model as plant
from cosim.conformance.fmi2 import ALLOCATE, FREE, LOGGER, Callbacks
from fmus.references import all_variables

ANSWERS = ("OK", "warning", "discard", "error", "fatal")
TABLE = {v.name: v for v in all_variables(plant)}
REALS = [TABLE[row[0]].value_reference for row in plant.VARIABLES if row[2]]
NO_VARIABLE = len(TABLE)
LAST_SUCCESSFUL_TIME, TERMINATED, DO_STEP_STATUS, PENDING_STATUS = 2, 3, 0, 1
STEP, STOP = 0.01, 1e5
NO_ARRAY = ctypes.POINTER(c_double)()
EMPTY = (c_double * 1)()
CO_SIMULATION, MODEL_EXCHANGE = 1, 0  # fmi2Type


class Library:
    """An FMU, the plant unless another is named, unpacked and loaded."""

    def __init__(self, path: Path, folder: str = "linux64", name: str = "AhvPlant"):
        self.folder = Path(fmpy.extract(str(path)))
        description = fmpy.read_model_description(str(path), validate=False)
        self.guid = description.guid or description.instantiationToken
        self.dll = ctypes.CDLL(str(self.folder / "binaries" / folder / f"{name}.so"))
        self.resources = (self.folder / "resources").as_uri()

    def close(self):
        shutil.rmtree(self.folder)


def of(*names):
    """References of variables as C wants them."""
    return (c_uint * len(names))(*(TABLE[name].value_reference if isinstance(name, str) else name for name in names))


class Talk:
    """One instance through FMI 2.0, called raw; `said` has (status, text) of its messages."""
    TYPES = MappingProxyType({"Real": c_double, "Boolean": c_int, "Integer": c_int, "String": c_char_p})

    def __init__(self, file, name="talk", guid=None, kind=CO_SIMULATION):
        self.dll, self.said = file.dll, []
        self.callbacks = Callbacks(LOGGER(self.log), ALLOCATE(("calloc", ctypes.CDLL(None))),
                                   FREE(("free", ctypes.CDLL(None))), None, None)
        self.dll.fmi2Instantiate.restype = c_void_p
        self.component = self.dll.fmi2Instantiate(
            name.encode(), kind, (guid or file.guid).encode(), file.resources.encode(), byref(self.callbacks), 0, 1)
        self.time = 0.0

    def log(self, _environment, _name, status, _category, text):
        self.said.append((ANSWERS[status], text.decode()))

    def call(self, name, *arguments):
        return ANSWERS[self.dll[f"fmi2{name}"](c_void_p(self.component), *arguments)]

    def setup(self, start=0.0, stop=STOP):
        return self.call("SetupExperiment", 0, c_double(0), c_double(start), 1, c_double(stop))

    def step(self, size=STEP, time=None):
        return self.call("DoStep", c_double(self.time if time is None else time), c_double(size), 0)

    def get(self, kind, *names):
        self.values = (self.TYPES[kind] * (len(names) or 1))()
        return self.call(f"Get{kind}", of(*names), c_size_t(len(names)), self.values)

    def set(self, kind, **values):
        packed = self.TYPES[kind] * len(values)
        return self.call(f"Set{kind}", of(*values), c_size_t(len(values)), packed(*values.values()))

    def everything(self):
        values = (c_double * len(REALS))()
        assert self.call("GetReal", of(*REALS), c_size_t(len(REALS)), values) == "OK"
        return list(values)

    def bring_to(self, state):
        place = STATES.index(state)
        done = [lambda: self.setup(), lambda: self.call("EnterInitializationMode"),
                lambda: self.call("ExitInitializationMode"), lambda: self.step(), lambda: self.call("Terminate")]
        for act in done[:(0, 2, 4, 5)[place]]:
            assert act() == "OK", self.said
        self.time = STEP if place >= 2 else 0.0

    def free(self):
        self.dll.fmi2FreeInstance(c_void_p(self.component))

    def state(self):
        found = c_void_p()
        assert self.call("GetFMUstate", byref(found)) == "OK"
        return found

    def blob(self, short=0):
        """A serialised state in a buffer that is `short` bytes too small, and what the call answered."""
        state, size = self.state(), c_size_t()
        assert self.call("SerializedFMUstateSize", state, byref(size)) == "OK"
        buffer = (ctypes.c_char * (size.value - short))()
        return buffer, self.call("SerializeFMUstate", state, buffer, c_size_t(size.value - short))

    def unpacked(self, changed=None):
        """A state deserialised from bytes of which one may be changed, and what the call answered."""
        buffer, _ = self.blob()
        if changed is not None:
            buffer[changed] = bytes([buffer[changed][0] ^ 1])
        state = c_void_p()
        return state, self.call("DeSerializeFMUstate", buffer, c_size_t(len(buffer)), byref(state))

    def put_back(self, changed):
        """What fmi2SetFMUstate answers to what was made of bytes of which one is changed."""
        state, _ = self.unpacked(changed)
        self.said.clear()
        return self.call("SetFMUstate", state)

    def derivative(self, unknown, known):
        return self.call("GetDirectionalDerivative", of(unknown), c_size_t(1), of(known), c_size_t(1),
                         (c_double * 1)(1.0), EMPTY)

    def status(self, name, kind):
        return self.call(name, kind, (c_double * 1)())

    def log_category(self, name):
        return self.call("SetDebugLogging", 1, c_size_t(1), (c_char_p * 1)(name.encode()))

    def after(self, act, starts=True, **values):
        """What `act` answers after a set that may be refused; the model may not be able to start from the values."""
        self.set("Real", **values)
        self.before = self.everything() if starts else None
        self.said.clear()
        return act()


# What FMI 3.0 calls otherwise.
NAMES3 = {"GetFMUstate": "GetFMUState", "SetFMUstate": "SetFMUState", "FreeFMUstate": "FreeFMUState",
          "SerializedFMUstateSize": "SerializedFMUStateSize", "SerializeFMUstate": "SerializeFMUState",
          "DeSerializeFMUstate": "DeserializeFMUState", "GetReal": "GetFloat64", "SetReal": "SetFloat64",
          "GetInteger": "GetInt32", "SetInteger": "SetInt32", "GetRealOutputDerivatives": "GetOutputDerivatives",
          "GetDerivatives": "GetContinuousStateDerivatives", "NewDiscreteStates": "UpdateDiscreteStates"}


class Talk3(Talk):
    """The same through FMI 3.0: calls are named as in FMI 2.0, and take the same arguments."""
    TYPES = MappingProxyType({"Real": c_double, "Boolean": c_bool, "Integer": c_int, "String": c_char_p})
    COUNTED = frozenset(f"{verb}{kind}" for kind in ("Float64", "Boolean", "Int32", "String")
                        for verb in ("Get", "Set"))

    def __init__(self, file, name="talk", guid=None, kind=CO_SIMULATION):
        self.dll, self.said, self.time = file.dll, [], 0.0
        self.logger = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)(self.log3)
        head = (name.encode(), (guid or file.guid).encode(), b"", c_bool(False), c_bool(True))
        make = self.dll.fmi3InstantiateCoSimulation if kind == CO_SIMULATION else self.dll.fmi3InstantiateModelExchange
        make.restype = c_void_p
        between = (c_bool(False), c_bool(False), None, c_size_t(0)) if kind == CO_SIMULATION else ()
        self.component = make(*head, *between, None, self.logger, *([None] if kind == CO_SIMULATION else []))

    def log3(self, _environment, status, _category, text):
        self.said.append((ANSWERS[status], text.decode()))

    def call(self, name, *arguments):
        name = NAMES3.get(name, name)
        if name == "EnterInitializationMode" and not arguments:
            return self.enter()
        if name in self.COUNTED:  # the number of values, which is that of the references
            arguments += arguments[1:2]
        elif name == "GetOutputDerivatives":
            arguments += (c_size_t(1),)
        return ANSWERS[self.dll[f"fmi3{name}"](c_void_p(self.component), *arguments)]

    def setup(self, start=0.0, stop=STOP):
        """Times are given where initialisation begins, so that this begins it."""
        return self.enter(start, stop)

    def enter(self, start=0.0, stop=STOP):
        return self.call("EnterInitializationMode", c_bool(False), c_double(0), c_double(start), c_bool(True),
                         c_double(stop))

    def step(self, size=STEP, time=None):
        self.flags, self.reached = [c_bool(True) for _ in range(3)], c_double()
        return self.call("DoStep", c_double(self.time if time is None else time), c_double(size), c_bool(False),
                         *map(byref, self.flags), byref(self.reached))

    def derivative(self, unknown, known, name="GetDirectionalDerivative"):
        one = c_size_t(1)
        return self.call(name, of(unknown), one, of(known), one, (c_double * 1)(1.0), one, EMPTY, one)

    def log_category(self, name):
        return self.call("SetDebugLogging", c_bool(True), c_size_t(1), (c_char_p * 1)(name.encode()))

    def bring_to(self, state):
        place = STATES.index(state)
        done = [self.enter, lambda: self.call("ExitInitializationMode"), self.step, lambda: self.call("Terminate")]
        for act in done[:(0, 1, 3, 4)[place]]:
            assert act() == "OK", self.said
        self.time = STEP if place >= 2 else 0.0

    def free(self):
        self.dll.fmi3FreeInstance(c_void_p(self.component))
