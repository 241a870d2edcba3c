"""What a native FMU accepts, what it refuses, and what it says: the contract of its interface."""
import ctypes
import math

import fmpy
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2LastSuccessfulTime,
    fmi2Terminated,
)
from native_loop import Loaded

DISCARD, ERROR = 2, 3


class Talking(Loaded):
    """A loaded FMU whose messages are kept in `said` as (status, category, text)."""

    def __init__(self, path, logging=True):
        super().__init__(path)
        self.path, self.said = path, []
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(self.log)
        self.callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self.callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self.slave = self.another("talking", logging)

    def another(self, name, logging=True, guid=None) -> FMU2Slave:
        slave = FMU2Slave(guid=guid or self.description.guid, unzipDirectory=str(self.folder), instanceName=name,
                          modelIdentifier=self.path.stem)
        slave.instantiate(callbacks=self.callbacks, loggingOn=logging)
        return slave

    def log(self, _environment, _name, status, category, text):
        self.said.append((status, category.decode(), text.decode()))

    def refuses(self, status, text, call, *arguments, **values):
        """Check that a call is refused with `status` and one sentence that has `text` in it."""
        self.said.clear()
        with pytest.raises(FMICallException) as refusal:
            call(*arguments, **values)
        assert refusal.value.status == status
        assert len(self.said) == 1 and self.said[0][0] == status and text in self.said[0][2], self.said

    def fly(self, first=0, last=10, step=0.01):
        for k in range(first, last):
            self.slave.doStep(k * step, step)
        return self.get(*self.names("output"))

    def serialised(self) -> bytes:
        state = self.slave.getFMUState()
        blob = self.slave.serializeFMUstate(state)
        self.slave.freeFMUState(state)
        return bytes(blob)


@pytest.fixture
def plant(native_fmus):
    with Talking(native_fmus["AhvPlant"]) as member:
        yield member


@pytest.fixture
def flying(plant):
    plant.begin()
    plant.shut()
    return plant


def test_another_guid_is_refused(plant):
    with pytest.raises(Exception, match=r"[Ii]nstantiate"):
        plant.another("stranger", guid="{wrong}")
    assert plant.said == [(ERROR, "logStatusError", f"the GUID {{wrong}} is not that of this AhvPlant, "
                                                    f"{plant.description.guid}")]


def test_calls_out_of_order_are_refused(plant):
    plant.refuses(ERROR, "can step only between initialisation and termination", plant.slave.doStep, 0.0, 0.01)
    plant.refuses(ERROR, "initialisation cannot end", plant.slave.exitInitializationMode)
    plant.refuses(ERROR, "can be terminated only after initialisation", plant.slave.terminate)
    plant.begin()
    plant.refuses(ERROR, "initialisation can begin once", plant.slave.enterInitializationMode)
    plant.refuses(ERROR, "set up before initialisation only", plant.slave.setupExperiment)
    plant.shut()
    plant.slave.terminate()
    plant.refuses(ERROR, "can step only", plant.slave.doStep, 0.0, 0.01)
    plant.refuses(ERROR, "elevator may not be set after termination", plant.set, elevator=0.1)
    assert plant.get("V") == [7700.0]


def test_a_parameter_out_of_its_range_is_discarded_and_the_old_value_stays(plant):
    plant.refuses(DISCARD, "V_start = 100 ft/s is below its minimum 5000 ft/s", plant.set, V_start=100.0)
    plant.refuses(DISCARD, "theta_start = 114.592 deg is above its maximum 80 deg", plant.set, theta_start=2.0)
    plant.refuses(DISCARD, "mass = nan is not a finite number", plant.set, mass=math.nan)
    plant.refuses(DISCARD, "mass = -inf is not a finite number", plant.set, h_start=90000.0, mass=-math.inf)
    assert plant.get("V_start", "theta_start", "mass", "h_start") == [7700.0, 0.0, 300.0, 85000.0]


def test_parameters_are_fixed_after_initialisation(flying):
    flying.refuses(ERROR, "mass is fixed", flying.set, mass=310.0)
    boolean = flying.references(["start_at_trim"])
    flying.refuses(ERROR, "start_at_trim is fixed", flying.slave.setBoolean, boolean, [False])


def test_outputs_may_not_be_set(plant):
    plant.refuses(ERROR, "V is an output and may not be set", plant.set, V=1.0)
    plant.refuses(ERROR, "theta_trim is a calculated parameter and may not be set", plant.set, theta_trim=1.0)


def test_what_is_no_variable_is_refused(plant):
    plant.refuses(ERROR, "value reference 4711 is no Real of AhvPlant", plant.slave.getReal, [4711])
    boolean = plant.references(["start_at_trim"])
    plant.refuses(ERROR, "is no Real of AhvPlant", plant.slave.getReal, boolean)
    plant.refuses(ERROR, "is no Boolean of AhvPlant", plant.slave.setBoolean, [0], [True])
    plant.refuses(ERROR, "is no Integer of AhvPlant", plant.slave.getInteger, [0])
    plant.refuses(ERROR, "is no String of AhvPlant", plant.slave.setString, [0], ["x"])


def test_an_input_that_is_no_number_is_refused_until_it_is_one(flying):
    flying.refuses(DISCARD, "elevator = nan is not a finite number and was refused at t = 0 s",
                   flying.set, elevator=math.nan)
    assert flying.get("elevator") == [pytest.approx(math.radians(12.511))]
    flying.refuses(DISCARD, "elevator = nan is not a finite number at t = 0 s", flying.slave.doStep, 0.0, 0.01)
    assert not flying.slave.getBooleanStatus(fmi2Terminated)
    flying.set(elevator=0.2)
    flying.fly()


@pytest.mark.parametrize("step", [0.0, -0.01, math.nan, math.inf])
def test_a_step_must_be_a_positive_number(flying, step):
    flying.refuses(DISCARD, "is not a positive number at t = 0 s", flying.slave.doStep, 0.0, step)


def test_a_step_that_would_never_end_is_refused(flying):
    flying.refuses(DISCARD, "takes too many internal steps", flying.slave.doStep, 0.0, 1e300)


def test_the_stop_time_is_the_end(plant):
    plant.slave.setupExperiment(startTime=0.0, stopTime=0.02)
    plant.slave.enterInitializationMode()
    plant.shut()
    plant.fly(0, 2)
    plant.refuses(ERROR, "past the stop time 0.02 s", plant.slave.doStep, 0.02, 0.01)


def test_outside_the_models_range_the_step_is_discarded_and_taken_back(plant):
    plant.begin()
    plant.slave.setBoolean(plant.references(["start_at_trim"]), [False])
    plant.set(gamma_start=-1.2, theta_start=-1.2, h_start=50000.0, fuel_ratio=0.0)
    plant.shut()
    with pytest.raises(FMICallException) as refusal:
        plant.fly(0, 1000)
    assert refusal.value.status == DISCARD
    status, category, text = plant.said[-1]
    assert (status, category) == (DISCARD, "logStatusDiscard")
    assert "is below its minimum" in text or "is above its maximum" in text
    reached = plant.slave.getRealStatus(fmi2LastSuccessfulTime)
    assert f"at t = {reached + 0.01:.6g} s" in text
    assert not plant.slave.getBooleanStatus(fmi2Terminated)  # a failure, no end of the simulation
    before = plant.get("V", "h")
    assert 3000 <= before[0] <= 20000 and 20000 <= before[1] <= 250000
    plant.slave.doStep(reached, 1e-9)  # and a step that stays inside is taken from there


def test_a_start_outside_the_models_range_is_refused(plant):
    plant.begin()
    plant.set(CL_alpha=0.0, CL_elevator=0.0)
    plant.said.clear()
    with pytest.raises(FMICallException) as refusal:
        plant.shut()
    assert refusal.value.status == ERROR and "AhvPlant cannot start:" in plant.said[0][2]


def test_outputs_follow_parameters_and_inputs_during_initialisation(plant):
    plant.begin()
    assert plant.get("V") == [7700.0]
    plant.set(V_start=8000.0)
    assert plant.get("V") == [8000.0]
    before = plant.get("thrust")
    plant.set(fuel_ratio=0.5)
    assert plant.get("thrust") > before


def test_reset_begins_again(flying):
    first = flying.fly()
    flying.slave.reset()
    flying.begin()
    flying.shut()
    assert flying.fly() == first


def test_a_state_restored_continues_bit_for_bit(flying):
    flying.fly(0, 10)
    state = flying.slave.getFMUState()
    later = flying.fly(10, 20)
    flying.slave.setFMUState(state)
    assert flying.fly(10, 20) == later
    flying.slave.freeFMUState(state)


def test_a_serialised_state_continues_in_another_instance(flying):
    flying.fly(0, 10)
    blob = flying.serialised()
    later = flying.fly(10, 20)
    with Talking(flying.path) as other:
        state = other.slave.deSerializeFMUstate(blob)
        other.slave.setFMUState(state)
        assert other.serialised() == blob
        assert other.fly(10, 20) == later
        other.slave.freeFMUState(state)


def test_foreign_states_are_refused(flying, native_fmus):
    blob = flying.serialised()
    with Talking(native_fmus["AhvController"]) as other:
        foreign = other.serialised()
    spoiled = [foreign, b"", b"\0" * len(blob), blob[:-1], blob + b"\0", *(
        blob[:at] + bytes([blob[at] ^ 1]) + blob[at + 1:] for at in range(0, len(blob), 7))]
    for bad in spoiled:
        flying.refuses(ERROR, "the state given is none of this AhvPlant", flying.slave.deSerializeFMUstate, bad)
    zeros = ctypes.create_string_buffer(4096)
    flying.refuses(ERROR, "the state given is none of", flying.slave.setFMUState, ctypes.cast(zeros, ctypes.c_void_p))
    assert flying.serialised() == blob


def test_instances_do_not_share_anything(plant):
    other = plant.another("other")
    for slave, elevator in ((plant.slave, 0.1), (other, 0.3)):
        slave.setupExperiment()
        slave.enterInitializationMode()
        slave.setReal(plant.references(["elevator"]), [elevator])
        slave.exitInitializationMode()
        slave.doStep(0.0, 0.01)
    a, b = (slave.getReal(plant.references(["elevator", "Q"])) for slave in (plant.slave, other))
    assert a[0] == 0.1 and b[0] == 0.3 and a[1] != b[1]
    component, other.component = other.component, None
    plant.slave.fmi2FreeInstance(component)


def test_refusals_are_told_without_debug_logging_too(native_fmus):
    """FMI 2.0 section 2.1.3: with fmi2Discard and fmi2Error the logger has been called in any case."""
    with Talking(native_fmus["AhvPlant"], logging=False) as quiet:
        quiet.refuses(ERROR, "V is an output", quiet.set, V=1.0)


def test_log_categories_are_heeded(plant):
    plant.slave.setDebugLogging(True, ["logStatusDiscard"])
    with pytest.raises(FMICallException):
        plant.set(V=1.0)
    assert plant.said == []
    plant.refuses(DISCARD, "mass = nan", plant.set, mass=math.nan)
    plant.refuses(DISCARD, "mass = nan", plant.set, mass=math.nan)
    plant.slave.setDebugLogging(True, ["logAll"])
    plant.refuses(ERROR, "AhvPlant has no log category nonsense", plant.slave.setDebugLogging, True, ["nonsense"])


@pytest.mark.parametrize("name", ["AhvPlant", "AhvController"])
@pytest.mark.parametrize("starting", [True, False])
def test_directional_derivatives_are_slopes(native_fmus, name, starting):
    """Against central differences: before the end of initialisation through the initial state, later at the state."""
    with Talking(native_fmus[name]) as member:
        member.begin()
        inputs, outputs = member.names("input"), member.names("output")
        references = member.references(outputs)
        if not starting:
            member.shut()
            member.fly()

        def outputs_with(known, value):
            if starting:
                member.set(**{known: value})
                return member.get(*outputs)
            state = member.slave.getFMUState()  # an instant step shows what the outputs are at this state
            member.set(**{known: value})
            member.slave.doStep(0.1, 1e-12)
            found = member.get(*outputs)
            member.slave.setFMUState(state)
            return found

        for known in inputs:
            value = member.get(known)[0]
            width = 1e-5 * float(member.variables[known].nominal)
            slopes = member.slave.getDirectionalDerivative(references, member.references([known]), [1.0])
            above, below = outputs_with(known, value + width), outputs_with(known, value - width)
            if starting:
                member.set(**{known: value})
            for output, slope, a, b in zip(outputs, slopes, above, below):
                rounding = 1e-9 * float(member.variables[output].nominal) / width
                assert slope == pytest.approx((a - b) / (2 * width), rel=1e-4, abs=rounding), (known, output)


def test_derivatives_have_inputs_and_outputs_only(flying):
    derivative, of = flying.slave.getDirectionalDerivative, flying.references
    flying.refuses(ERROR, "mass is not among the knowns", derivative, of(["V"]), of(["mass"]), [1.0])
    flying.refuses(ERROR, "elevator is not among the unknowns", derivative, of(["elevator"]), of(["elevator"]), [1.0])
