"""The co-simulated closed loop against the monolithic one in continuous time."""
from itertools import pairwise
from math import log2

import numpy as np
import pyarrow.parquet
import pytest
from oracle import ClosedLoop
from test_cases import flown

import ahv_plant_fmu.model as plant

STOP, GRID = 16.0, 0.016
STEPS = (0.001, 0.002, 0.004, 0.008)
NOMINAL = {name: nominal for name, kind, _, _, _, _, nominal, _ in plant.VARIABLES if kind == "output"}


@pytest.fixture(scope="module")
def exact():
    times = np.arange(round(STOP / GRID) + 1) * GRID
    return ClosedLoop("case1").solve(times)[:, :9]


def test_the_loop_converges_to_the_oracle_with_first_order(exact, tmp_path):
    print("\nlargest error / nominal over Case 1, 0-16 s\n step", *(f"{name:>9}" for name in plant.STATES))
    errors = []
    for step in STEPS:
        flown(tmp_path, "case1", "--flavour", "native", "--step", step, "--stop", STOP)
        table = pyarrow.parquet.read_table(tmp_path / "out" / "signals.parquet")
        every = round(GRID / step)
        found = np.array([table[f"plant.{name}"].to_numpy()[::every] for name in plant.STATES]).T
        nominal = [NOMINAL[name] for name in plant.STATES]
        errors.append(np.max(np.abs(found - exact) / nominal, axis=0))
        print(f"{step:.3f}", *(f"{e:9.2e}" for e in errors[-1]))
    orders = np.array([[log2(b / a) for a, b in zip(fine, coarse)] for fine, coarse in pairwise(errors)])
    print("order", *(f"{o:9.2f}" for o in orders.mean(axis=0)))
    worst = np.max(errors, axis=1)
    print("order of the worst variable:", [round(log2(b / a), 4) for a, b in pairwise(worst)])
    assert all(b / a >= 2 for a, b in pairwise(worst))  # order 1 or better
    assert orders.min() > 0.99  # each variable's own scatters about 1 in the third digit
