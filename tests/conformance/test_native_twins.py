"""The two flavours are one model: the same variables, and the same numbers wherever they fly."""
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from native_loop import Loaded, record

from cosim.vehicle.registry import MODELS

STEP = 0.01
TABLE = ("name", "valueReference", "causality", "variability", "initial", "type", "start", "min", "max", "nominal",
         "unit", "displayUnit", "description")


def distance(a: float, b: float, nominal: float) -> float:
    return abs(a - b) / max(nominal, abs(a))


def nominals(member: Loaded, names) -> list[float]:
    return [float(member.variables[name].nominal or 1.0) for name in names]


@pytest.mark.parametrize("name", MODELS)
def test_both_flavours_declare_the_same(python_fmus, native_fmus, name):
    with Loaded(python_fmus[name]) as python, Loaded(native_fmus[name]) as native:
        assert list(python.variables) == list(native.variables)[:len(python.variables)]
        further = list(native.variables.values())[len(python.variables):]  # for model exchange: states and their rates
        assert {v.causality for v in further} <= {"local"}
        assert sum(v.derivative is not None for v in further) == native.description.numberOfContinuousStates
        for variable, twin in zip(python.variables.values(), native.variables.values()):
            assert [getattr(variable, key) for key in TABLE] == [getattr(twin, key) for key in TABLE]
        assert len(python.description.outputs) == len(native.description.outputs)


@pytest.mark.parametrize("case", ["case1", "case2"])
def test_both_flavours_fly_the_same(python_fmus, native_fmus, case):
    """Relative to each signal's nominal: to rounding, over 100 s."""
    python, native = (record(fmus["AhvPlant"].parent, case).signals for fmus in (python_fmus, native_fmus))
    worst = 0.0
    for model, label in (("AhvScenario", "scenario"), ("AhvController", "controller"), ("AhvPlant", "plant")):
        with Loaded(native_fmus[model]) as member:
            for name in member.names("output"):
                nominal = float(member.variables[name].nominal or 1.0)
                a, b = python[f"{label}.{name}"], native[f"{label}.{name}"]
                worst = max(worst, max(abs(x - y) for x, y in zip(a, b)) / nominal)
    print(f"{case}: largest relative difference {worst:.2g}")
    assert worst < 1e-9


class Pair:
    """Both flavours of one FMU, begun again from instantiation for each example."""

    def __init__(self, python: Loaded, native: Loaded):
        self.members = [(member, member.slave.getFMUState()) for member in (python, native)]
        self.outputs = python.names("output")
        self.nominals = nominals(python, self.outputs)

    def worst_of_one_step(self, parameters: dict, at_start: dict, during_step: dict, booleans=()) -> float:
        results = []
        for member, instantiated in self.members:
            member.slave.setFMUState(instantiated)
            member.begin()
            member.set(**parameters, **at_start)
            for name, value in booleans:
                member.slave.setBoolean(member.references([name]), [value])
            member.shut()
            member.set(**during_step)
            member.slave.doStep(0.0, STEP)
            results.append(member.get(*self.outputs))
        return max(distance(a, b, n) for a, b, n in zip(*results, self.nominals))

    def noise(self, time: float, **parameters) -> list[float] | None:
        """What the sensors of angles show at the start, away from trim, where all are 0; None if the two differ."""
        results = []
        for member, instantiated in self.members:
            member.slave.setFMUState(instantiated)
            member.slave.setupExperiment(startTime=time)
            member.slave.enterInitializationMode()
            member.slave.setBoolean(member.references(["start_at_trim"]), [False])
            member.set(**parameters)
            results.append(member.get("gamma", "theta", "Q"))
        return results[0] if results[0] == results[1] and all(results[0]) else None


def between(low: float, high: float):
    return st.floats(low, high, allow_nan=False)


PLANT_START = {"V_start": between(5000, 15000), "h_start": between(50000, 150000), "gamma_start": between(-0.5, 0.5),
               "theta_start": between(-0.5, 0.5), "Q_start": between(-1, 1), "eta1_start": between(-5, 5),
               "eta1_dot_start": between(-50, 50), "eta2_start": between(-5, 5), "eta2_dot_start": between(-50, 50)}
PLANT_INPUT = {"fuel_ratio": between(0, 1.5), "elevator": between(-0.4, 0.4), "scale_thrust": between(0.5, 1.5),
               "scale_lift": between(0.5, 1.5), "scale_drag": between(0.5, 1.5), "scale_moment": between(0.5, 1.5),
               "scale_forces": between(0.5, 1.5)}
CONTROLLER_INPUT = {"V": between(7000, 9000), "h": between(80000, 90000), "gamma": between(-0.02, 0.02),
                    "theta": between(-0.05, 0.1), "Q": between(-0.1, 0.1), "V_command": between(7000, 9000),
                    "h_command": between(80000, 90000)}
THOUSAND = settings(max_examples=1000, deadline=None, derandomize=True, database=None,
                    suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture
def pair(request, python_fmus, native_fmus):
    with Loaded(python_fmus[request.param]) as python, Loaded(native_fmus[request.param]) as native:
        yield Pair(python, native)


@pytest.mark.parametrize("pair", ["AhvPlant"], indirect=True)
@THOUSAND
@given(st.fixed_dictionaries(PLANT_START), st.fixed_dictionaries(PLANT_INPUT))
def test_one_step_of_the_plant_from_anywhere(pair, start, held):
    assert pair.worst_of_one_step(start, held, held, [("start_at_trim", False)]) < 1e-12


@pytest.mark.parametrize("pair", ["AhvController", "AhvBackstepping", "AhvResilient"], indirect=True)
@THOUSAND
@given(st.fixed_dictionaries(CONTROLLER_INPUT), st.fixed_dictionaries(CONTROLLER_INPUT))
def test_one_step_of_a_controller_from_anywhere(pair, at_start, held):
    assert pair.worst_of_one_step({}, at_start, held) < 1e-12


@pytest.mark.parametrize("pair", ["AhvInstrumentedPlant"], indirect=True)
@settings(max_examples=100, deadline=None, derandomize=True, database=None,
          suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(1, 2**31 - 2), st.floats(0, 1e6))
def test_the_noise_of_a_seed_is_the_same_bits(pair, seed, time):
    """Of angles that are 0 but for it, so that nothing is lost in a sum."""
    assert pair.noise(time, noise_seed=seed, gamma_noise=0.1, theta_noise=0.1, Q_noise=1.0)
