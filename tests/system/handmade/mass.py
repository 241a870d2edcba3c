"""A point mass, built by pythonfmu's own command: a = force / mass, stepped by semi-implicit Euler."""
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Mass(Fmi2Slave):

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.mass = 1.0
        self.force = 0.0
        self.position = 1.0
        self.velocity = 0.0
        self.register_variable(Real("mass", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        self.register_variable(Real("force", causality=Fmi2Causality.input))
        self.register_variable(Real("position", causality=Fmi2Causality.output))
        self.register_variable(Real("velocity", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.velocity += step_size * self.force / self.mass
        self.position += step_size * self.velocity
        return True
