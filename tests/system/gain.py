"""A small FMU of pythonfmu's own make for tests of SSP: y = k * u, a whole number, a truth and a text; it can crash."""
import os

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String

PARAMETER = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}


class Gain(Fmi2Slave):

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y, self.k, self.n, self.on, self.label = 0.0, 0.0, 1.0, 0, True, ""
        self.whole = 0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        self.register_variable(Integer("whole", causality=Fmi2Causality.output))
        self.register_variable(Real("k", **PARAMETER))
        self.register_variable(Integer("n", **PARAMETER))
        self.register_variable(Boolean("on", **PARAMETER))
        self.register_variable(String("label", **PARAMETER))

    def do_step(self, current_time, step_size):
        if self.label == "crash" and current_time > 0.6:
            os.abort()
        self.y = self.k * self.u if self.on else 0.0
        return True
