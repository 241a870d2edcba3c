"""A spring and damper, built by pythonfmu's own command; the force is that at the end of a step."""
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Spring(Fmi2Slave):

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.stiffness = 10.0
        self.damping = 0.2
        self.position = 0.0
        self.velocity = 0.0
        self.force = 0.0
        for name in ("stiffness", "damping"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        for name in ("position", "velocity"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        self.register_variable(Real("force", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.force = -self.stiffness * self.position - self.damping * self.velocity
        return True
