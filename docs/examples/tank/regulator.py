"""A level controller with stock pythonfmu: a pump that is driven by the level's error and its integral."""
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

PARAMETER = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}


class Regulator(Fmi2Slave):
    """Levels in m, flows in m3/s."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.wanted, self.kp, self.ki, self.pump_max = 3.0, 1.0, 0.3, 1.5
        self.level = self.flow = self.integral = 0.0
        self.register_variable(Real("level", causality=Fmi2Causality.input))
        self.register_variable(Real("flow", causality=Fmi2Causality.output))
        for name in ("wanted", "kp", "ki", "pump_max"):
            self.register_variable(Real(name, **PARAMETER))

    def do_step(self, current_time, step_size):
        """One sample; the integral waits while the pump is at a limit."""
        error = self.wanted - self.level
        asked = self.kp * error + self.integral
        self.flow = max(0.0, min(self.pump_max, asked))
        if self.flow == asked:
            self.integral += step_size * self.ki * error
        return True
