"""The vehicle's mass from noisy measurements of five flights."""
import numpy as np
import pytest

from cosim.cli.fit import subject_of
from cosim.fitting.fit import fit
from cosim.master.fly import fly

MASS = 330.0  # slug/ft; the vehicle has 300
STARTS = [(7700, 85000), (8200, 88000), (7900, 83000), (8600, 92000), (9000, 95000)]  # ft/s, ft
NOISE = {"plant.V": 3.0, "plant.h": 10.0, "plant.theta": 0.003, "plant.load_factor": 0.02,
         "controller.fuel_ratio": 0.02}
STEP, STOP, EVERY = 0.02, 8.0, 10


def subject():
    """Case 1 under the resilient law."""
    return subject_of("case1", "resilient", None, None, "ideal", None, None, ["plant.mass"], [])


def clean(loop):
    """What the five flights of the heavier vehicle show: a table each, without noise."""
    found = []
    for V, h in STARTS:
        flight = fly(loop.build([f"plant.mass={MASS}", f"plant.V_start={V}", f"plant.h_start={h}"]), STEP, STOP,
                     record=list(NOISE))
        found.append(np.column_stack([flight.time, *(flight[name] for name in NOISE)])[::EVERY])
    return found


def fitted(loop, tables, folder, seed):
    """The fit of these tables with noise."""
    rng = np.random.default_rng(seed)
    names, words = [], []
    for k, (rows, (V, h)) in enumerate(zip(tables, STARTS)):
        noisy = rows.copy()
        noisy[:, 1:] += rng.standard_normal(noisy[:, 1:].shape) * list(NOISE.values())
        path = folder / f"flight_{k + 1}.csv"
        np.savetxt(path, noisy, fmt="%.9g", delimiter=",", header=",".join(["time", *NOISE]), comments="")
        names.append(str(path))
        words += [f"{path}:plant.V_start={V}", f"{path}:plant.h_start={h}"]
    return fit(loop, names, ["plant.mass"], values=words, step=STEP)


@pytest.mark.slow
def test_five_flights_tell_the_mass(native_fmus, tmp_path):
    with subject() as loop:
        found = fitted(loop, clean(loop), tmp_path, 1)
    low, high = found.intervals_95["plant.mass"]
    assert low < MASS < high and high - low < 3.0 and found.summary["warnings"] == []
    for name, size in NOISE.items():
        assert found.summary["signals"][name]["noise"] == pytest.approx(size, rel=0.2), name


@pytest.mark.slow
def test_the_interval_covers_the_mass_in_95_of_100_repetitions(native_fmus, tmp_path):
    """90 at least: of intervals that cover with 95 %, 97 % of such hundreds do."""
    with subject() as loop:
        tables = clean(loop)
        found = [fitted(loop, tables, tmp_path, seed) for seed in range(100)]
    values = np.array([one.values["plant.mass"] for one in found])
    covered = sum(low < MASS < high for low, high in (one.intervals_95["plant.mass"] for one in found))
    half = np.mean([(high - low) / 2 for low, high in (one.intervals_95["plant.mass"] for one in found)])
    print(f"{covered} of 100 cover {MASS:g}; mean {values.mean():.3f}, spread {values.std():.3f}, mean half-width "
          f"{half:.3f}")
    assert covered >= 90 and abs(values.mean() - MASS) < 4 * values.std() / 10
    assert half == pytest.approx(1.96 * values.std(), rel=0.25)
