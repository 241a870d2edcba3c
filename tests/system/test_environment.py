"""A system as an environment of Gymnasium: by Gymnasium's own checker, equal to flights, and safe to learn on."""
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import psutil
import pytest
import small
from gymnasium.utils.env_checker import check_env

import cosim
from cosim.errors import RunError, UsageError
from cosim.ssp.write import write
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop

ID = "cosim.ecosystems.environment:cosim/System-v0"
ACTIONS = ["plant.fuel_ratio", "plant.elevator"]
STATES = ["plant.V", "plant.h", "plant.gamma", "plant.theta", "plant.Q"]


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return small.build(tmp_path_factory.mktemp("environments"))


@pytest.fixture(scope="module")
def loop(native_fmus):
    return closed_loop(scenarios.load("case1"), flavour="native").system


@pytest.fixture
def made():
    """Makes environments that are closed afterwards."""
    found = []

    def make(*arguments, **options):
        found.append(cosim.Environment(*arguments, **options))
        return found[-1]
    yield make
    for one in found:
        one.close()


def mass(fmu, **changed):
    """One mass on a spring."""
    return cosim.System([cosim.Component("mass", fmu, small.oscillator(**changed))], (), 0.01, 1.0)


def flying(loop, made, *functions, **options):
    return made(loop, ACTIONS, [*STATES, "scenario.h_command"], *functions, without=["controller"], **{
        "step": 0.01, "stop": 10.0, **options})


# --- Gymnasium's rules ------------------------------------------------------------------------------------------------

def test_the_vehicle_keeps_gymnasiums_rules(loop):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(
            ID, system=loop, actions=ACTIONS, observations=STATES, without=["controller"], stop=10.0, step=0.01,
            reward=lambda now: -abs(now["plant.h"] - 85_000.0), values={"plant.mass": (280.0, 320.0)}).unwrapped)


@pytest.mark.parametrize("options", [
    {"actions": {"mass.u": (-2.0, 2.0)}, "hold": 5}, {"actions": ["mass.whole_in", "mass.truth_in"]},
    {"actions": ["mass.u", "mass.truth_in"], "algorithm": "jacobi"}], ids=["real", "whole", "mixed"])
def test_another_system_keeps_gymnasiums_rules(fmu, options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(ID, system=mass(fmu), observations=["mass.y", "mass.y2", "mass.whole_out"],
                                 reward=lambda now: -now["mass.y"] ** 2, **options).unwrapped)


def test_environments_fly_beside_each_other_in_processes_of_their_own(fmu):
    environments = gymnasium.make_vec(ID, num_envs=2, vectorization_mode="async", system=mass(fmu), actions=["mass.u"],
                                      observations=["mass.y"], values={"mass.x1": (0.5, 1.5)})
    first, _ = environments.reset(seed=3)
    then, *_ = environments.step(np.zeros((2, 1)))
    environments.close()
    assert first.shape == then.shape == (2, 1) and first[0, 0] != first[1, 0]


def test_without_gymnasium_one_sentence_says_what_to_install():
    code = "import sys; sys.modules['gymnasium'] = None; import cosim; cosim.System; cosim.Environment"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stderr.splitlines()[-1] == ("cosim.errors.UsageError: cosim.Environment needs gymnasium, which is not "
                                            "installed: pip install gymnasium.")


# --- what it flies ----------------------------------------------------------------------------------------------------

def test_an_agent_that_does_what_the_controller_did_flies_what_it_flew(loop, made):
    flight = cosim.fly(loop, 0.01, 10.0, progress=False)
    environment = made(loop, {"plant.fuel_ratio": (0.0, 2.0), "plant.elevator": (-0.5, 0.5)}, STATES, step=0.01,
                       stop=10.0, without=["controller"], scaled=False, signals=["plant.load_factor"])
    environment.reset()
    acted = np.column_stack([flight["controller.fuel_ratio"], flight["controller.elevator"]])
    shown = [environment.step(action)[0] for action in acted[1:]]
    assert (np.array(shown) == np.column_stack([flight[name] for name in STATES])[1:]).all()
    assert (environment.flight["plant.load_factor"][1:] == flight["plant.load_factor"][1:]).all()
    assert environment.flight.finished and (environment.flight["plant.elevator"][1:] == acted[1:, 1]).all()


def test_an_ssp_of_fmi_3_flies_as_the_system_of_fmi_2_does(loop, made, native_fmi3_fmus, tmp_path):
    other = closed_loop(scenarios.load("case1"), flavour="native-fmi3").system
    write(tmp_path / "loop.ssp", "loop", other, 0.01, 2.0)
    ends = []
    for one in (flying(loop, made, stop=2.0), made(tmp_path / "loop.ssp", ACTIONS, [*STATES, "scenario.h_command"],
                                                  without=["controller"])):
        one.reset()
        random = np.random.default_rng(2)
        while not (end := one.step(random.uniform(-0.2, 0.2, 2)))[3]:
            assert not end[2]
        ends.append(end)
    assert (ends[0][0] == ends[1][0]).all() and ends[0][4]["time"] == ends[1][4]["time"] == pytest.approx(2.0)


def test_an_action_holds_for_as_many_steps_as_asked(fmu, made):
    every, fifth = (made(mass(fmu), {"mass.u": (-2.0, 2.0)}, ["mass.y", "mass.y2"], hold=hold) for hold in (1, 5))
    every.reset(), fifth.reset()
    for action in np.linspace(-1.0, 1.0, 20):
        last = [every.step([action]) for _ in range(5)][-1]
        held = fifth.step([action])
        assert (held[0] == last[0]).all() and held[2:] == last[2:]
    assert held[3] and held[4]["time"] == pytest.approx(1.0)


def test_actions_from_minus_1_to_1_stand_for_the_limits_and_whole_numbers_are_rounded(fmu, made):
    environment = made(mass(fmu), {"mass.u": (1.0, 3.0), "mass.whole_in": (-4, 4)}, ["mass.y"],
                       signals=["mass.whole_out"])
    environment.reset()
    for action, given in (((-1, -1), (1, -4)), ((0.5, 0.3), (2.5, 1)), ((7, -7), (3, -4))):
        environment.step(np.array(action, float))
        assert (environment.now["mass.u"], environment.now["mass.whole_in"], environment.now["mass.whole_out"]) == (
            *given, given[1])


def test_what_no_limit_is_declared_for_gets_the_limits_that_the_page_tells(loop, made, fmu):
    environment = flying(loop, made)
    found = {port.name: (port.low, port.high, port.unit) for port in (*environment.actions, *environment.observations)}
    start = 0.21835814271701057
    assert found["plant.elevator"] == (start - 0.1, start + 0.1, "rad")
    assert found["plant.V"] == (3000.0, 20000.0, "ft/s") and found["plant.Q"] == (-10.0, 10.0, "rad/s")
    given = made(mass(fmu, u=3.0), ["mass.u", "mass.truth_in"], {"mass.y": (-5, 5), "mass.truth_out": None})
    ports = [*given.actions, *given.observations]
    assert [(port.low, port.high) for port in ports] == [(2, 4), (0, 1), (-5, 5), (0, 1)]


def test_a_reward_and_a_condition_may_be_expressions(fmu, made):
    words = made(mass(fmu), ["mass.u"], ["mass.y2"], "-abs(mass.y - 2) ** 2 + mass.u", "mass.y < 0.9 and mass.x1 > 0")
    functions = made(mass(fmu), ["mass.u"], ["mass.y2"], lambda now: -abs(now["mass.y"] - 2) ** 2 + now["mass.u"],
                     lambda now: now["mass.y"] < 0.9, signals=["mass.y"])
    words.reset(), functions.reset()
    shown = [], []
    while not (shown[0] and shown[0][-1][1]):
        for one, steps in zip((words, functions), shown):
            steps.append(one.step([0.3])[1:4])
    assert shown[0] == shown[1] and len(shown[0]) > 10


def test_a_moment_knows_the_one_before(fmu, made):
    seen = []
    environment = made(mass(fmu), ["mass.u"], ["mass.y"],
                       lambda now: seen.append((now.before.time, now.time, now.before.before)) or
                       now["mass.y"] - now.before["mass.y"])
    first, _ = environment.reset()
    then, reward, *_ = environment.step([0.0])
    assert reward == then[0] - first[0] and seen == [(0.0, 0.01, None)]
    environment.step([0.0])
    assert seen[1] == (0.01, 0.02, None)


# --- how episodes begin -----------------------------------------------------------------------------------------------

def test_values_are_drawn_by_the_seed_and_options_stand_over_them(fmu, made):
    environment = made(mass(fmu), ["mass.u"], ["mass.y"], values={
        "mass.x1": (0.5, 1.5), "mass.a22": lambda random: random.normal(-0.3, 0.01), "mass.a21": -9.0})
    drawn = [environment.reset(seed=seed)[1]["values"] for seed in (5, None, 5, 6)]
    assert drawn[0] == drawn[2] and drawn[0] not in (drawn[1], drawn[3])
    assert all(0.5 <= values["mass.x1"] <= 1.5 and values["mass.a21"] == -9.0 for values in drawn)
    shown, info = environment.reset(options={"mass.x1": 2.0})
    assert shown[0] == info["values"]["mass.x1"] == 2.0
    assert environment.reset(options={"mass.x1": (3.0, 4.0)})[0][0] >= 3.0
    assert environment.reset()[0][0] < 2.0


def test_options_change_no_draw_of_a_later_episode(fmu, made):
    environment = made(mass(fmu), ["mass.u"], ["mass.y"], values={
        "mass.x1": (0.5, 1.5), "mass.a22": lambda random: random.normal(-0.3, 0.01)})

    def three(*options):
        return [environment.reset(seed=None if k else 5, options=one)[1]["values"] for k, one in enumerate(options)]

    plain = three(None, None, None)
    assert three(None, {"mass.x1": 2.0}, None) == [plain[0], {**plain[1], "mass.x1": 2.0}, plain[2]]
    told = {"mass.x1": (2.0, 3.0), "mass.a21": lambda random: -random.uniform(8, 10)}
    first, again = three(told, told, None), three(told, told, None)
    assert first == again and first[0]["mass.x1"] != first[1]["mass.x1"] and first[2] == plain[2]
    assert [one["mass.a22"] for one in first] == [one["mass.a22"] for one in plain]


def test_an_input_begins_as_the_system_says(fmu, made):
    environment = made(mass(fmu, u=3.0), {"mass.u": (-5.0, 5.0)}, ["mass.y"])
    environment.reset()
    assert environment.now["mass.u"] == 3.0
    environment.step([0.0])
    environment.reset(options={"mass.u": -1.0})
    assert environment.now["mass.u"] == -1.0


# --- how they end -----------------------------------------------------------------------------------------------------

def falling(fmu, made, fault, **options):
    environment = made(mass(fmu, fault=small.FAULTS.index(fault), fault_time=0.045), ["mass.u"], ["mass.y"],
                       lambda now: 1.0, penalty=10.0, **options)
    environment.reset()
    shown = [environment.step([0.0])]
    while not shown[-1][2]:
        shown.append(environment.step([0.0]))
    return environment, shown


@pytest.mark.parametrize("fault,words,lost", [
    ("discard", "answered Discard to fmi2DoStep at t = 0.05 s", True), ("error", "answered Error", True),
    ("fatal", "answered Fatal", True), ("end", "ended the simulation at t = 0.0", False),
    ("not_a_number", "At t = 0.06 s mass.y is nan, beyond its limits (mass.y: -1000 to 1000)", True)])
def test_an_episode_ends_with_a_flight_that_is_lost_or_over(fmu, made, fault, words, lost):
    environment, shown = falling(fmu, made, fault)
    assert {step[2:4] for step in shown[:-1]} == {(False, False)} and shown[-1][2:4] == (True, False)
    assert len(shown) == (6 if lost else 5)
    observation, reward, _, _, info = shown[-1]
    assert words in info["message"] and reward == (-9.0 if lost else 1.0)
    assert observation in environment.observation_space
    if lost:
        assert observation[0] == shown[-2][0][0]
    assert environment.flight.finished == (not lost) and environment.flight.message == info["message"]
    with pytest.raises(UsageError, match="The episode is over"):
        environment.step([0.0])
    environment.reset(options={"mass.fault": 0})  # loaded anew where the FMU answered Fatal
    assert environment.step([0.0])[2:4] == (False, False)


def test_a_condition_ends_an_episode_and_the_stop_cuts_it(fmu, made):
    environment = made(mass(fmu), ["mass.u"], ["mass.y"], terminated=lambda now: now["mass.y"] < 0.0)
    environment.reset()
    while not (shown := environment.step([0.0]))[2]:
        assert shown[0][0] >= 0.0
    assert shown[0][0] < 0.0 and shown[4]["message"] == "" and environment.flight.time[-1] == shown[4]["time"]
    quiet = made(mass(fmu), ["mass.u"], ["mass.y"])
    quiet.reset()
    ends = [quiet.step([0.0])[2:4] for _ in range(100)]
    assert ends == [(False, False)] * 99 + [(False, True)]


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_no_fmu_sees_an_action_that_is_not_finite(fmu, made, wrong):
    environment = made(mass(fmu), ["mass.u"], ["mass.y"])
    environment.reset()
    with pytest.raises(UsageError, match=f"The action for mass.u is {wrong}; it must be a finite number."):
        environment.step([wrong])
    assert environment.flight.ticks == 0 and environment.step([0.0])[4]["time"] == 0.01


# --- what does not fit ------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("options,words", [
    ({"actions": ["mass.uu"]}, "actions: mass.uu is no input that takes numbers; did you mean mass.u?"),
    ({"actions": ["mass.y"]}, "actions: mass.y is no input that takes numbers"),
    ({"actions": ["mass.text_in"]}, "actions: mass.text_in is no input that takes numbers"),
    ({"actions": []}, "actions is empty: name at least one"),
    ({"actions": "mass.u"}, "actions = 'mass.u' is not allowed: it must be a list of names"),
    ({"actions": 3}, "actions = 3 is not allowed"),
    ({"actions": ["mass.u", "mass.u"]}, "actions has mass.u twice."),
    ({"actions": {"mass.u": (1.0, 1.0)}}, "the limits of mass.u are (1.0, 1.0); they must be two numbers"),
    ({"actions": {"mass.u": (0.0, np.inf)}}, "mass.u = inf is not allowed: it must be between"),
    ({"actions": {"mass.u": 3.0}}, "the limits of mass.u are 3.0"),
    ({"actions": {"mass.whole_in": (0.5, 2)}}, "mass.whole_in = 0.5 is not allowed: it must be a whole number."),
    ({"observations": ["mass.z"]}, "observations: mass.z is no variable that is a number"),
    ({"observations": {"mass.y": (np.nan, 1.0)}}, "the limits of mass.y are (nan, 1.0)"),
    ({"reward": "-mass.yy"}, "reward: mass.yy is no variable that is a number; did you mean mass.y?"),
    ({"reward": "mass.y +"}, "reward: 'mass.y +' is not an expression."), ({"reward": 3}, "reward = 3 is not allowed"),
    ({"reward": "mass.y > 1"}, "reward: 'mass.y > 1' is true or false"),
    ({"reward": "mean(mass.y)"}, "reward: 'mean(mass.y)'"),
    ({"terminated": "mass.y"}, "terminated: 'mass.y' is neither true nor false"),
    ({"hold": 3}, "hold = 3 is not allowed: it must be a whole number that divides the 100 communication steps"),
    ({"hold": True}, "hold = True is not allowed"),
    ({"step": "fast"}, "step = 'fast' is not allowed: it must be a number of seconds."),
    ({"stop": -1.0}, "step 0.01 and stop -1 must be positive numbers of seconds."),
    ({"algorithm": "variable"}, "algorithm variable is not allowed: inputs are given step by step"),
    ({"without": ["wing"]}, "There is no component wing; there are mass."),
    ({"without": ["mass"]}, "actions: mass.u is no input that takes numbers"),
    ({"system": "nothing.fmu"}, "There is no FMU at nothing.fmu"),
    ({"system": 3}, "system = 3 is not allowed: it must be a cosim.System, a file or a scenario."),
    ({"system": "case7"}, "case7 is neither a scenario"),
])
def test_what_does_not_fit_is_one_sentence(fmu, made, options, words):
    with pytest.raises(UsageError) as caught:
        made(**{"system": mass(fmu), "actions": ["mass.u"], "observations": ["mass.y"], **options})
    assert words in str(caught.value) and str(caught.value).count("\n") == 0 and "--" not in str(caught.value)


@pytest.mark.parametrize("options,words", [
    ({"mass.mas": 1.0}, "has no variable mas"), ({"wing.x": 1.0}, "There is no component wing"),
    ({"mass.x1": np.nan}, "mass.x1 = nan is not allowed"), ({"mass.x1": (2.0, 1.0)}, "the limits of mass.x1"),
    ({"mass.x1": [1.0]}, "the limits of mass.x1"), ({"mass.x1": lambda random: None}, "mass.x1 = None is not allowed"),
    ({"mass.x1": 2000.0}, "At t = 0 s mass.y is 2000, beyond its limits (mass.y: -1000 to 1000). Give other limits"),
])
def test_values_that_do_not_fit_are_one_sentence_and_the_next_reset_is_well(fmu, made, options, words):
    environment = made(mass(fmu), ["mass.u"], ["mass.y"])
    with pytest.raises(UsageError) as caught:
        environment.reset(options=options)
    assert words in str(caught.value)
    with pytest.raises(UsageError, match="did not begin"):
        environment.step([0.0])
    assert environment.reset()[0][0] == 1.0


def test_a_connected_input_is_no_action(fmu, made):
    with pytest.raises(UsageError, match=r"actions has the input right\.u, which left\.y feeds"):
        made(small.pair(fmu), ["right.u"], ["right.y"], step=0.01, stop=1.0).reset()


def test_an_action_of_another_shape_and_a_signal_that_is_not_kept_are_told(fmu, made):
    environment = made(mass(fmu), ["mass.u"], ["mass.y"], lambda now: now["mass.y2"])
    environment.reset()
    with pytest.raises(UsageError, match=r"An action of shape \(2,\) is not allowed: it must be \(1,\), for mass.u."):
        environment.step([0.0, 0.0])
    with pytest.raises(KeyError, match=r"There is no signal mass\.y2; did you mean mass\.y"):
        environment.step([0.0])


def test_a_start_that_an_fmu_refuses_is_a_run_error_and_the_next_reset_is_well(fmu, made):
    environment = made(mass(fmu), ["mass.u"], ["mass.y"])
    with pytest.raises(RunError):
        environment.reset(options={"mass.fault": small.FAULTS.index("refuse_init")})
    assert environment.reset()[0][0] == 1.0


def test_a_closed_environment_can_be_closed_again_and_reset(fmu, made):
    environment = made(mass(fmu), ["mass.u"], ["mass.y"])
    environment.reset()
    environment.close(), environment.close()
    with pytest.raises(UsageError):
        environment.step([0.0])
    assert environment.reset()[0][0] == 1.0


@pytest.mark.slow
def test_100_000_steps_take_no_more_memory(loop, made):
    environment = flying(loop, made, lambda now: -abs(now.before["plant.h"]), values={"plant.mass": (280.0, 320.0)})
    environment.reset(seed=1)
    used, process = [], psutil.Process()
    for step in range(100_000):
        if any(environment.step(0.1 * environment.action_space.sample())[2:4]):
            environment.reset()
        if step in (20_000, 99_999):
            used.append(process.memory_info().rss)
    print(used)
    assert used[1] - used[0] < 1_000_000
