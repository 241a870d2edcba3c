"""Model exchange integrated by fmpy's CVode, against scipy's DOP853 on the models' own equations."""
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from native_loop import Loaded
from oracle import MEASURED, ClosedLoop
from scipy.integrate import solve_ivp
from solved import Member, solve
from test_plant_accuracy import exact, random_case

import ahv_plant_fmu.model as plant

ACTIONS, COMMANDS = ("fuel_ratio", "elevator"), ("V_command", "h_command")
MANY = pytest.param(1000, marks=pytest.mark.slow)


@pytest.fixture(params=["native_fmus", "native_fmi3_fmus"])
def fmus(request):
    return request.getfixturevalue(request.param)


@pytest.fixture
def vehicle(fmus):
    member = Member(fmus["AhvPlant"])
    yield member
    member.close()


@pytest.fixture
def law(fmus):
    member = Member(fmus["AhvController"])
    yield member
    member.close()


@pytest.mark.parametrize("count", [5, MANY])
def test_the_plant_with_held_inputs_for_a_second(vehicle, count):
    """It is unstable by itself, so that the solver's error grows: with a relative tolerance of 1e-10 to 4e-7 of nominal
    in a second, which is why the solver gets 1e-13 here. Where it leaves the model's range it says so."""
    rng, worst, left = np.random.default_rng(1), 0.0, 0
    for _ in range(count):
        start, inputs, structure = random_case(rng)
        vehicle.begin([("start_at_trim", False)], inputs.items(), **start, **structure)
        try:
            reached = solve([vehicle], 1.0, 1e-13)
        except FMICallException as refusal:
            assert refusal.status == 2
            left += 1
            continue
        worst = max(worst, np.max(np.abs(reached - exact(start, inputs, structure, 1.0)) / vehicle.nominal))
    print(f"{count} states, {left} left the model's range: largest error / nominal {worst:.2g}")
    assert worst <= 1e-8 and left < 0.2 * count


@pytest.mark.parametrize("count", [2, MANY])
def test_plant_and_controller_for_a_second_of_closed_loop(vehicle, law, count):
    """From states of Case 1, with commands and scales held, both FMUs in one solver: the difference is that of the
    solver's tolerance. At 1e-10 it is above 1e-8 of nominal, since V and h are 8 and 85 nominals large."""
    loop, worst = ClosedLoop("case1"), dict.fromkeys((1e-10, 1e-12), 0.0)
    times = np.linspace(0.0, 0.1 * (count - 1), count)
    states = loop.solve(times, rtol=1e-9)
    rate, n = loop.traced_rate(), 9 + law.n
    absolute = 1e-12 * np.concatenate([vehicle.nominal, law.nominal, np.ones(states.shape[1] - n)])

    def wire():
        law.set(**dict(zip(MEASURED, vehicle.x)))
        vehicle.set(**dict(zip(ACTIONS, law.get(*ACTIONS))))

    for time, x in zip(times, states):
        held = vars(loop.inputs(time, x[:9]))
        law.begin(at_start={name: vars(loop.inputs(0.0, loop.x0))[name] for name in (*MEASURED, *COMMANDS)}.items())
        vehicle.begin()
        law.set(**{name: held[name] for name in COMMANDS})
        vehicle.set(**{name: value for name, value in held.items() if name.startswith("scale")})
        right = solve_ivp(lambda _t, y, at=time: rate(at, y), (0.0, 1.0), x, method="DOP853", rtol=1e-12,
                          atol=absolute).y[:9, -1]
        for rtol in worst:
            vehicle.put(x[:9])
            law.put(x[9:n])
            reached = solve([vehicle, law], 1.0, rtol, wire)[:9]
            worst[rtol] = max(worst[rtol], np.max(np.abs(reached - right) / vehicle.nominal))
    print(f"{count} states of the closed loop: largest error / nominal by the solver's tolerance: {worst}")
    assert worst[1e-10] <= 1e-6 and worst[1e-12] <= 1e-8


def test_co_simulation_at_1_ms_agrees(vehicle, native_fmus):
    """Its method of order six has less error then than the solver's tolerance leaves."""
    held = {"elevator": 0.23, "fuel_ratio": 0.4}
    vehicle.begin(at_start=held.items())
    solved = solve([vehicle], 1.0, 1e-13)
    with Loaded(native_fmus["AhvPlant"]) as stepped:
        stepped.begin()
        stepped.set(**held)
        stepped.shut()
        for k in range(1000):
            stepped.slave.doStep(k * 1e-3, 1e-3)
        assert np.max(np.abs(stepped.get(*plant.STATES) - solved) / vehicle.nominal) < 1e-8


def test_a_flag_changes_at_events_only_and_a_completed_step_asks_for_one(law):
    """It is discrete: in continuous time it keeps its value, however far the command is."""
    law.begin()
    assert law.fmu.completedIntegratorStep()[0] in (0, False) and law.get("elevator_saturated") == [0.0]
    law.set(h=84000.0)
    assert law.get("elevator_saturated", "h_error") == [0.0, -1000.0]
    assert law.fmu.completedIntegratorStep()[0] in (1, True)
    law.fmu.enterEventMode()
    assert law.get("elevator_saturated") == [1.0]
    law.to_continuous_time()
    assert law.fmu.completedIntegratorStep()[0] in (0, False) and law.get("elevator_saturated") == [1.0]


def test_the_states_are_those_of_the_model(vehicle):
    assert vehicle.states == plant.STATES
