"""The closed loop in continuous time, integrated by scipy's DOP853: what the co-simulation converges to."""
from types import SimpleNamespace

import casadi
import numpy as np
from scipy.integrate import solve_ivp

import ahv_ctrl_fmu.neural as law
import ahv_ctrl_fmu.neural_model as controller
import ahv_plant_fmu.model as plant
import cosim.vehicle.scenario_model as scenario
from ahv_plant_fmu.equations import derivative
from fmus import floats, symbols

MEASURED = ("V", "h", "gamma", "theta", "Q")


def starts(model, causality, **changed):
    """The start values of a model's inputs or parameters as a namespace, some of them changed."""
    values = {name: start for name, kind, _, start, *_ in model.VARIABLES if kind == causality}
    assert set(changed) <= set(values)
    return SimpleNamespace(**{**values, **changed})


class ClosedLoop:
    """Plant (9 states) and neural controller under a scenario, without any sampling."""

    def __init__(self, case="case1", **gains):
        self.case = starts(scenario, "parameter", **scenario.PRESETS[case])
        self.gains = starts(controller, "parameter", **gains)
        self.vehicle = starts(plant, "parameter")
        self.x0 = plant.start(floats, None, self.vehicle)[:9]
        self.z0 = law.start(floats, self.inputs(0.0, self.x0), self.gains)

    def inputs(self, t, x, m=floats):
        signals = scenario.outputs(m, t, [], None, self.case)
        return SimpleNamespace(**dict(zip(MEASURED, x)), **signals)

    def rate(self, t, y, m=floats):
        x, z = list(y[:9]), list(y[9:])
        u = self.inputs(t, x, m)
        sent = law.outputs(m, t, z, u, self.gains)
        return [*derivative(m, x, sent["fuel_ratio"], sent["elevator"], plant.scales(u), self.vehicle),
                *law.derivative(m, t, z, u, self.gains), *[0.0] * (len(z) - len(controller.STATES))]

    def traced_rate(self):
        """`rate` through CasADi: ten times as fast as floats."""
        t, y = casadi.SX.sym("t"), casadi.SX.sym("y", 9 + len(self.z0))
        function = casadi.Function("rate", [t, y], [casadi.vertcat(*self.rate(t, casadi.vertsplit(y), symbols))])
        time, state, result = np.zeros(1), np.zeros(y.numel()), np.zeros(y.numel())
        buffer, evaluate = function.buffer()
        buffer.set_arg(0, memoryview(time))
        buffer.set_arg(1, memoryview(state))
        buffer.set_res(0, memoryview(result))

        def rate(t, y):
            time[0], state[:] = t, y
            evaluate()
            return result.copy()

        rate.keep = buffer  # type: ignore[attr-defined]  (evaluate needs it alive)
        return rate

    def solve(self, times, rtol=1e-12):
        """States at `times` (s), shape (times, 28): plant, then controller. Edges of the scenario must not
        lie strictly inside the span."""
        atol = np.concatenate([1e-12 * np.array([1e3, 1e3, .01, .01, .01, 1, 20, 1, 20]), np.full(len(self.z0), 1e-14)])
        solution = solve_ivp(self.traced_rate(), (times[0], times[-1]), [*self.x0, *self.z0], method="DOP853",
                             t_eval=times, rtol=rtol, atol=atol)
        assert solution.success
        return solution.y.T
