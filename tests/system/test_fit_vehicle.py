"""The vehicle's mass from noisy measurements of five flights."""
from dataclasses import replace

import numpy as np
import pytest

from cosim.cli.fit import subject_of
from cosim.fitting.fit import asked, solved
from cosim.fitting.flown import flying
from cosim.master.fly import fly

MASS = 330.0  # slug/ft; the vehicle has 300
STARTS = [(7700, 85000), (8200, 88000), (7900, 83000), (8600, 92000), (9000, 95000)]  # ft/s, ft
NOISE = {"plant.V": 3.0, "plant.h": 10.0, "plant.theta": 0.003, "plant.load_factor": 0.02,
         "controller.fuel_ratio": 0.02}
STEP, STOP, EVERY, REPETITIONS = 0.02, 8.0, 10, 100


@pytest.fixture(scope="module")
def request_without_noise(native_fmus, tmp_path_factory):
    """What five flights of the heavier vehicle show, Case 1 under the resilient law, as a request for a fit."""
    folder, names, words = tmp_path_factory.mktemp("flights"), [], []
    with subject_of("case1", "resilient", None, None, "ideal", None, None, ["plant.mass"], []) as loop:
        for k, (V, h) in enumerate(STARTS):
            flight = fly(loop.build([f"plant.mass={MASS}", f"plant.V_start={V}", f"plant.h_start={h}"]), STEP, STOP,
                         record=list(NOISE))
            rows = np.column_stack([flight.time, *(flight[name] for name in NOISE)])[::EVERY]
            path = folder / f"flight_{k + 1}.csv"
            np.savetxt(path, rows, delimiter=",", header=",".join(["time", *NOISE]), comments="")
            names.append(str(path))
            words += [f"{path}:plant.V_start={V}", f"{path}:plant.h_start={h}"]
        return asked(loop, names, ["plant.mass"], [], words, None, STEP, None, None, None)


def noisy(request, seed):
    """The request with noise in what was measured."""
    rng = np.random.default_rng(seed)
    return replace(request, measured=[replace(one, signals={
        name: values + NOISE[name] * rng.standard_normal(len(values)) for name, values in one.signals.items()})
        for one in request.measured])


@pytest.mark.slow
def test_the_interval_covers_the_mass_in_90_of_100_repetitions(request_without_noise):
    """Of intervals that cover with 95 %, 98.9 % of such hundreds have 90 at least."""
    with flying(request_without_noise.plans, 0) as fly_trials:
        found = [solved(noisy(request_without_noise, seed), fly_trials) for seed in range(REPETITIONS)]
    values = np.array([one.values["plant.mass"] for one in found])
    ends = np.array([one.intervals_95["plant.mass"] for one in found])
    covered = int(((ends[:, 0] < MASS) & (ends[:, 1] > MASS)).sum())
    half = float(np.mean(ends[:, 1] - ends[:, 0]) / 2)
    print(f"{covered} of {REPETITIONS} cover {MASS:g}; mean {values.mean():.3f}, spread {values.std():.3f}, "
          f"mean half-width {half:.3f}")
    assert covered >= 90 and abs(values.mean() - MASS) < 4 * values.std() / 10
    assert half == pytest.approx(1.96 * values.std(), rel=0.25)
    for name, size in NOISE.items():
        levels = [one.summary["signals"][name]["noise"] for one in found]
        assert np.mean(levels) == pytest.approx(size, rel=0.02), name
