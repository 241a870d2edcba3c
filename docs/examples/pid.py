"""A PID controller for the vehicle, with stock pythonfmu: python -m pythonfmu build -f pid.py"""
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

INPUTS = {"V": 7700.0, "h": 85000.0, "gamma": 0.0, "theta": 0.02849, "Q": 0.0,
          "V_command": 7700.0, "h_command": 85000.0}
OUTPUTS = {"fuel_ratio": 0.26703, "elevator": 0.21836, "V_reference": 7700.0, "h_reference": 85000.0}
FUEL_RATIO, ELEVATOR, THETA = 0.26703, 0.21836, 0.02849  # level flight at 7700 ft/s and 85000 ft


class PidController(Fmi2Slave):
    """Altitude -> flight-path angle -> pitch angle -> elevator, and velocity -> fuel ratio. Feet, seconds, radians."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.V_rate = self.h_rate = self.V_integral = self.h_integral = 0.0
        for causality, table in ((Fmi2Causality.input, INPUTS), (Fmi2Causality.output, OUTPUTS)):
            for name, start in table.items():
                setattr(self, name, start)
                self.register_variable(Real(name, causality=causality))

    def do_step(self, current_time, step_size):
        for name in ("V", "h"):  # references: the commands through a filter of 0.1 rad/s, damping 0.9
            rate, reference = getattr(self, f"{name}_rate"), getattr(self, f"{name}_reference")
            rate += step_size * (0.01 * (getattr(self, f"{name}_command") - reference) - 0.18 * rate)
            setattr(self, f"{name}_rate", rate)
            setattr(self, f"{name}_reference", reference + step_size * rate)

        h_error, V_error = self.h - self.h_reference, self.V - self.V_reference
        self.h_integral += step_size * h_error
        self.V_integral += step_size * V_error
        gamma_command = (self.h_rate - 0.4 * h_error - 0.08 * self.h_integral) / self.V
        theta_command = THETA + gamma_command + 12.0 * (gamma_command - self.gamma)
        elevator = ELEVATOR + 10.0 * (self.theta - theta_command) + 3.0 * self.Q  # up pitches the nose down
        fuel_ratio = FUEL_RATIO + self.V_rate / 25.0 - 0.2 * V_error - 0.05 * self.V_integral
        self.elevator = max(-0.349, min(0.349, elevator))
        self.fuel_ratio = max(0.05, min(1.5, fuel_ratio))
        return True
