"""Actuators, sensors and delay lines of the instrumented plant, one at a time, on plain floats."""
import math

import pytest
from oracle import starts

import ahv_plant_fmu.instrumented_model as model
import ahv_plant_fmu.model as plant
from ahv_plant_fmu.noise import samples
from fmus import floats
from fmus.integrators import advancing

H = model.TAP
SENSORS = [name for name, *_ in model.SENSORS]


def flown(steps, h=H, commands=None, **parameters):
    """(state, outputs) after each step from the start; commands(k) are the inputs that are set before step k."""
    u, p = starts(model, "input"), starts(model, "parameter", **parameters)
    x = model.start(floats, u, p)
    rows = [(x, model.outputs(floats, 0.0, x, u, p))]
    for k in range(steps):
        for name, value in (commands(k) if commands else {}).items():
            setattr(u, name, value)
        x = model.advance(floats, k * h, h, x, u, p, [])
        rows.append((x, model.outputs(floats, (k + 1) * h, x, u, p)))
    return rows


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_lag_is_exact_in_both_directions(way):
    later, acts = model.actuator_step(floats, 0.5, 0.5 + way, bandwidth=20.0, rate=0.0, h=0.01)
    assert later == pytest.approx(0.5 + way * (1 - math.exp(-0.2)), rel=1e-15)
    assert acts == pytest.approx((0.5 + later) / 2)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("bandwidth", [0.0, 20.0])
def test_a_rate_limit_holds_back_in_both_directions(way, bandwidth):
    later, acts = model.actuator_step(floats, 0.5, 0.5 + way, bandwidth, rate=2.0, h=0.01)
    assert later == pytest.approx(0.5 + way * 0.02, rel=1e-15)
    assert acts == pytest.approx(0.5 + way * 0.01, rel=1e-15)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_command_that_is_near_is_reached_within_the_rate_limit(way):
    later, _ = model.actuator_step(floats, 0.5, 0.5 + way * 0.01, bandwidth=0.0, rate=2.0, h=0.01)
    assert later == 0.5 + way * 0.01


def test_without_lag_and_limit_the_command_acts_at_once():
    assert model.actuator_step(floats, 0.5, 0.7, 0.0, 0.0, 0.01) == (0.7, 0.7)


@pytest.mark.parametrize("name", ["fuel_ratio", "elevator"])
def test_an_actuator_uses_its_own_command_bandwidth_limit_and_delay(name):
    other = {"fuel_ratio": "elevator", "elevator": "fuel_ratio"}[name]
    began = getattr(starts(model, "input"), name)
    commands = {name: began - 0.1, other: getattr(starts(model, "input"), other) - 0.05}

    def used(**parameters):
        _, y = flown(1, commands=lambda _: commands, **parameters)[-1]
        assert y[f"{other}_used"] == commands[other]
        return y[f"{name}_used"]

    assert used() == commands[name]
    assert used(**{f"{name}_bandwidth": 20.0}) == pytest.approx(began - 0.1 * (1 - math.exp(-20 * H)))
    assert used(**{f"{name}_rate_limit": 2.0}) == pytest.approx(began - 2.0 * H)
    assert used(**{f"{name}_delay": 10 * H}) == began


def test_the_vehicle_moves_by_what_acts():
    """On average over the step, where an actuator lags or is limited; each by its own."""
    u, p = starts(model, "input"), starts(model, "parameter", fuel_ratio_bandwidth=20.0, elevator_rate_limit=2.0)
    x = model.start(floats, u, p)
    fuel, elevator = u.fuel_ratio, u.elevator
    u.fuel_ratio, u.elevator = fuel + 0.1, elevator - 0.1
    stepped = model.advance(floats, 0.0, H, x, u, p, [])
    u.fuel_ratio, u.elevator = fuel + 0.05 * (1 - math.exp(-20 * H)), elevator - H
    expected = advancing(plant)(floats, 0.0, H, x[:model.VEHICLE], u, p, [])
    assert stepped[:model.VEHICLE] == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("name", ["fuel_ratio", "elevator"])
def test_a_command_passes_its_delay_on_the_tick(name):
    began = getattr(starts(model, "input"), name)
    rows = flown(6, commands=lambda k: {name: began - 0.01 * (k + 1)}, **{f"{name}_delay": 3 * H})
    shown = [y[f"{name}_used"] for _, y in rows]
    assert shown == pytest.approx([began] * 4 + [began - 0.01, began - 0.02, began - 0.03])


@pytest.mark.parametrize("name", SENSORS)
def test_each_sensor_has_its_own_delay(name):
    rows = flown(8, commands=lambda k: {"elevator": 0.1, "fuel_ratio": 0.9}, **{f"{name}_delay": 3 * H})
    for shown in SENSORS:
        late = 3 if shown == name else 0
        true = [y[f"{shown}_true"] for _, y in rows]
        assert [y[shown] for _, y in rows[late:]] == pytest.approx(true[:len(rows) - late], rel=1e-12, abs=1e-15)
        assert [y[shown] for _, y in rows[:late]] == pytest.approx([true[0]] * late)


def test_between_grid_points_a_delay_is_read_by_straight_lines():
    line = [10.0, 20.0, 40.0, *[0.0] * (model.TAPS - 3)]
    assert model.delayed(floats, 7.0, line, 0.0, 0.002) == 7.0
    assert model.delayed(floats, 7.0, line, 0.001, 0.002) == 7.0  # not yet on the line
    assert model.delayed(floats, 7.0, line, 0.002, 0.002) == pytest.approx(10.0)
    assert model.delayed(floats, 7.0, line, 0.002 + 0.25 * H, 0.002) == pytest.approx(12.5)
    assert model.delayed(floats, 7.0, line, 0.002 + 1.5 * H, 0.002) == pytest.approx(30.0)


def test_a_line_holds_every_delay_that_the_table_allows():
    longest = next(row[5] for row in model.VARIABLES if row[0] == "Q_delay")
    rows = flown(model.TAPS + 2, commands=lambda k: {"elevator": 0.1}, Q_delay=longest)
    late = round(longest / H)
    assert rows[-1][1]["Q"] == pytest.approx(rows[len(rows) - 1 - late][1]["Q_true"], rel=1e-9)


def test_grid_points_are_counted_despite_rounding():
    assert [model.ticks(floats, t) for t in (0.0, 0.0049, 0.005, 0.1 + 0.2, 0.3 - 1e-12, 0.3 - 1e-6)] == [
        0, 0, 1, 60, 60, 59]


@pytest.mark.parametrize("name", SENSORS)
def test_each_sensor_has_its_own_noise_of_the_tick_and_no_other_changes(name):
    plain = flown(5, h=0.002)
    noisy = flown(5, h=0.002, noise_seed=7.0, **{f"{name}_noise": 0.01})
    for k, ((_, y), (_, z)) in enumerate(zip(plain, noisy)):
        sample = samples(floats, 7.0, float(model.ticks(floats, k * 0.002)), len(SENSORS))[SENSORS.index(name)]
        assert z[name] == pytest.approx(y[name] + 0.01 * sample, rel=1e-15)
        assert {n: v for n, v in z.items() if n != name} == {n: v for n, v in y.items() if n != name}


def test_as_built_is_every_part_in_the_amount_that_it_says():
    preset = model.PRESETS["as-built"]
    assert {n: v for n, v in preset.items() if v != model.PRESETS["decoupled"][n]} == {
        "fuel_ratio_bandwidth": 20.0, "elevator_bandwidth": 20.0, "elevator_rate_limit": math.radians(100),
        "V_delay": 0.005, "h_delay": 0.005, "gamma_delay": 0.005, "theta_delay": 0.005, "Q_delay": 0.005,
        "V_noise": 0.1, "h_noise": 0.3, "gamma_noise": 2e-5, "theta_noise": 2e-5, "Q_noise": 2e-4}
    assert {n: v for n, v in preset.items() if n in plant.PRESETS["decoupled"]} == plant.PRESETS["decoupled"]
    u = starts(model, "input")
    down = {"elevator": u.elevator - 0.1, "fuel_ratio": u.fuel_ratio + 0.1}
    rows = flown(2, commands=lambda _: down, **preset)
    y = rows[1][1]
    assert y["elevator_used"] == pytest.approx(u.elevator - math.radians(100) * H)
    assert y["fuel_ratio_used"] == pytest.approx(u.fuel_ratio + 0.1 * (1 - math.exp(-20 * H)))
    for name in SENSORS:
        noise = samples(floats, 1.0, 2.0, 5)[SENSORS.index(name)] * preset[f"{name}_noise"]
        assert rows[2][1][name] == pytest.approx(rows[1][1][f"{name}_true"] + noise, rel=1e-12, abs=1e-16)


def test_the_other_presets_switch_everything_off():
    for name in ("decoupled", "estimated-coupling"):
        assert {n: v for n, v in model.PRESETS[name].items() if n not in plant.PRESETS[name]} == model.OFF
        assert {n: model.PRESETS[name][n] for n in plant.PRESETS[name]} == plant.PRESETS[name]
    assert set(model.OFF.values()) == {0.0, 1.0} and model.OFF["noise_seed"] == 1.0
