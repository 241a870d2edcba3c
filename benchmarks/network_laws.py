"""An experimental law: `resilient` with the paper's altitude network, (11), (56), (57), in its pitch loop.

    .venv/bin/python benchmarks/network_laws.py [FOLDER]      (builds it, else into results/laws)
    ahv run case1 --controller mine=results/laws/native/ResilientNetwork.fmu --set controller.lambda_2=1000

The network sees gamma, theta, Q and the elevator, and the error E = Q - (pitch rate wanted). Its signal,
E phi h^T h / 2, is taken off the pitch acceleration that the law asks for, and phi' = lambda_2 E^2 h^T h / 2 - 2 phi.
The boxes and widths are those of the neural law's preset `calibrated`; the elevator's is 0 to 0.35 rad, with a width in
the same proportion.
Without the law's own estimates (IN_THEIR_PLACE) the network is all that knows of a changed moment.
"""
import sys
from pathlib import Path
from unittest.mock import patch

from protected_laws import OUT, module

from ahv_ctrl_fmu import resilient as r
from ahv_ctrl_fmu import resilient_model
from ahv_ctrl_fmu.neural import activation
from ahv_ctrl_fmu.neural_model import CALIBRATED
from fmus.builder import build

IN_THEIR_PLACE = {"filter_moment": 1e-9, "moment_gain": 0.0}  # neither pitch disturbance nor moment scale
BOX = {name: tuple(CALIBRATED[f"net2_{name}_{key}"] for key in ("min", "max", "width"))
       for name in ("gamma", "theta", "Q")}
ELEVATOR = 0.0, 0.35, 0.35 * CALIBRATED["net2_delta0_width"] / CALIBRATED["net2_delta0_max"]
ROWS = [
    ("phi_hat_2", "output", "1/s", None, None, None, 1.0, "adapted parameter of the network (57)"),
    ("lambda_2", "parameter", "s/rad^2", 0.0, 0.0, None, None, "adaptation gain of the network (57)"),
]


def start(m, u, p):
    """The law's own, and phi = 0."""
    return [*r.start(m, u, p), 0.0]


def advance(m, t, h, x, u, p, c):
    """The law's own, its demand less the network's signal."""
    seen, own = {}, r.commanded

    def commanded(m, s, u, now, p):
        law = own(m, s, u, now, p)
        E = -(law.demand + s.s_M * now.mu * (now.c + r.v.CM_0) + s.d_M) / p.k_Q
        hh = activation(m, (*((getattr(u, name), *box) for name, box in BOX.items()), (s.servo, *ELEVATOR)))
        law.demand = law.demand - 0.5 * E * x[-1] * hh
        seen["growth"] = 0.5 * p.lambda_2 * E * E * hh
        return law

    with patch.object(r, "commanded", commanded):
        state = r.advance(m, t, h, x[:-1], u, p, c)
    decay = m.exp(-2 * h)
    return [*state, decay * x[-1] + (1 - decay) / 2 * seen["growth"]]


def outputs(m, t, x, u, p):
    """The law's own, and phi."""
    return {**r.outputs(m, t, x[:-1], u, p), "phi_hat_2": x[-1]}


MODEL = module("ResilientNetwork", resilient_model, DESCRIPTION="with the paper's network in its pitch loop",
               VARIABLES=[*resilient_model.VARIABLES, *ROWS],
               PRESETS={"quiet": {**resilient_model.QUIET, "lambda_2": 0.0}},
               prepare=r.prepare, start=start, advance=advance, outputs=outputs)

if __name__ == "__main__":
    print(build(MODEL, "native", Path(sys.argv[1]) if sys.argv[1:] else OUT))
