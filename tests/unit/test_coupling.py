"""The structure that pushes back: which sign of its coupling keeps energy."""
import numpy as np
import pytest
from oracle import starts

from ahv_plant_fmu import model as plant
from ahv_plant_fmu.equations import derivative
from ahv_plant_fmu.trim import NOMINAL
from fmus import floats

FREE = {name: 0.0 for name, *_ in plant.COEFFICIENTS
        if name.startswith(("beta", "CL", "CD", "CM", "N1", "N2", "zeta"))}  # no forces, no damping


def power(sign, x):
    """d/dt of the rotational and elastic energy of (4)-(7) without forces, lbf.ft/s per foot, over the energy."""
    p = starts(plant, "parameter", psi_1=-363.5, psi_2=328.8, coupling_sign=sign, **FREE)
    Q, eta, rate = x[4], x[[5, 7]], x[[6, 8]]
    dx = np.array(derivative(floats, list(x), 0.0, 0.0, NOMINAL, p))
    dQ, d_rate = dx[4], dx[[6, 8]]
    psi, omega = np.array([p.psi_1, p.psi_2]), np.array([p.omega_1, p.omega_2])
    energy = 0.5 * p.pitch_inertia * Q**2 - Q * psi @ rate + 0.5 * rate @ rate + 0.5 * (omega * eta) @ (omega * eta)
    change = p.pitch_inertia * Q * dQ - dQ * psi @ rate - Q * psi @ d_rate + rate @ d_rate + (omega**2 * eta) @ rate
    return change / energy


@pytest.mark.parametrize("seed", range(5))
def test_the_turned_sign_keeps_energy_the_printed_one_does_not(seed):
    rng = np.random.default_rng(seed)
    x = np.array([7700, 85000, 0, 0.03, *rng.normal(size=5) * [0.01, 1, 20, 1, 20]])
    assert abs(power(-1.0, x)) < 1e-10
    assert abs(power(1.0, x)) > 1e-3


def test_without_coupling_the_sign_is_nothing():
    x = [7700.0, 85000.0, 0.01, 0.03, 0.02, 1.0, 2.0, 0.8, -3.0]
    rates = [derivative(floats, x, 0.3, 0.2, NOMINAL, starts(plant, "parameter", coupling_sign=s)) for s in (1.0, -1.0)]
    assert rates[0] == rates[1]
