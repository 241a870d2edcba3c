"""Actuators and sensors as they are: off they change nothing, on they do what their parameters say."""
import numpy as np
import pytest
from evidence import fly

FIVE = ("V", "h", "gamma", "theta", "Q")


@pytest.fixture(scope="module")
def plain():
    return fly("case1", values={"plant": {"internal_step": 0.004}}, stop=20)


def instrumented(stop=20, **parameters):
    return fly("case1", values={"plant": {"internal_step": 0.004, **parameters}}, plant="instrumented", stop=stop)


def test_switched_off_they_do_not_change_a_bit(plain):
    flight = instrumented()
    names = [c.name for c in plain.columns]
    assert np.array_equal(plain.signals, np.column_stack([flight[name] for name in names]))
    assert all(np.array_equal(flight[f"plant.{n}"], flight[f"plant.{n}_true"]) for n in FIVE)


def test_a_delayed_sensor_shows_what_was(plain):
    flight = fly("case1", values={"plant": {"Q_delay": 0.03, "h_delay": 0.025}}, plant="instrumented", stop=10)
    Q, shown = flight["plant.Q_true"], flight["plant.Q"]
    assert np.allclose(shown[3:], Q[:-3], rtol=1e-9, atol=1e-12) and np.abs(shown - Q).max() > 1e-4
    h, shown = flight["plant.h_true"], flight["plant.h"]  # half-way between two ticks, and the line is read straight
    assert np.allclose(shown[3:], (h[1:-2] + h[:-3]) / 2, rtol=0, atol=2e-3)


def test_noise_has_the_given_size_is_white_and_comes_from_its_seed():
    sizes = {"V_noise": 0.1, "h_noise": 0.3, "gamma_noise": 2e-5, "theta_noise": 3e-5, "Q_noise": 1e-4}
    flight, other = instrumented(**sizes), instrumented(**sizes, noise_seed=2.0)
    for name in FIVE:
        noise = (flight[f"plant.{name}"] - flight[f"plant.{name}_true"])[1:]
        assert noise.std() == pytest.approx(sizes[f"{name}_noise"], rel=0.05)
        assert abs(np.mean(noise)) < 0.1 * noise.std()
        assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.1
        assert not np.array_equal(noise, (other[f"plant.{name}"] - other[f"plant.{name}_true"])[1:])


def test_lag_and_rate_limit_hold_the_elevator_back():
    limit = np.radians(2.0)
    flight = instrumented(elevator_rate_limit=limit, elevator_bandwidth=20.0, stop=5)
    used = flight["plant.elevator_used"]
    assert np.abs(np.diff(used)).max() <= 0.01 * limit * (1 + 1e-9)
    assert np.abs(np.diff(used)).max() > 0.0099 * limit
    assert np.abs(np.diff(flight["controller.elevator"])).max() > 0.01 * limit
