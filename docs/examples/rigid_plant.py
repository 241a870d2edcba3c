"""The vehicle as a rigid body, with stock pythonfmu: python -m pythonfmu build -f rigid_plant.py

Ports as those of AhvPlant, in feet, seconds, slugs and radians, per foot of depth. No flexible modes: the generalised
forces, and so `scale_forces`, act on nothing.
"""
from math import cos, exp, sin

from pythonfmu import Fmi2Causality, Fmi2Slave, Real

INPUTS = {"fuel_ratio": 0.26703, "elevator": 0.21836, "scale_thrust": 1.0, "scale_lift": 1.0, "scale_drag": 1.0,
          "scale_moment": 1.0, "scale_forces": 1.0}
STATES = {"V": 7700.0, "h": 85000.0, "gamma": 0.0, "theta": 0.02849, "Q": 0.0}
MASS, INERTIA, AREA, CHORD, ARM, GRAVITY = 300.0, 5e5, 17.0, 17.0, 8.36, 32.0


class RigidPlant(Fmi2Slave):

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for causality, table in ((Fmi2Causality.input, INPUTS), (Fmi2Causality.output, STATES)):
            for name, start in table.items():
                setattr(self, name, start)
                self.register_variable(Real(name, causality=causality))

    def derivative(self, state):
        V, h, gamma, theta, Q = state
        alpha, delta = theta - gamma, self.elevator
        area = 0.5 * 6.7429e-5 * exp((85000.0 - h) / 21358.0) * V * V * AREA  # dynamic pressure times area, lbf/ft
        thrust = self.scale_thrust * (
            self.fuel_ratio * (((-3.7693e5 * alpha + 2.6814e4) * alpha + 3.5542e4) * alpha + 6378.5)
            + ((-3.7225e4 * alpha - 1.7277e4) * alpha - 2421.6) * alpha - 100.9)
        lift = self.scale_lift * area * (4.6773 * alpha + 0.76224 * delta - 0.018714)
        drag = self.scale_drag * area * ((5.8224 * alpha - 0.045315) * alpha
                                         + (0.81993 * delta + 2.7699e-4) * delta + 0.010131)
        moment = ARM * thrust + self.scale_moment * area * CHORD * (
            (6.2926 * alpha + 2.1335) * alpha + 0.18979 - 1.2897 * delta)
        return ((thrust * cos(alpha) - drag) / MASS - GRAVITY * sin(gamma),
                V * sin(gamma),
                (lift + thrust * sin(alpha)) / (MASS * V) - GRAVITY * cos(gamma) / V,
                Q,
                moment / INERTIA)

    def do_step(self, current_time, step_size):
        x = [getattr(self, name) for name in STATES]  # one step of the classical Runge-Kutta method
        k1 = self.derivative(x)
        k2 = self.derivative([a + 0.5 * step_size * b for a, b in zip(x, k1)])
        k3 = self.derivative([a + 0.5 * step_size * b for a, b in zip(x, k2)])
        k4 = self.derivative([a + step_size * b for a, b in zip(x, k3)])
        for name, a, p, q, r, s in zip(STATES, x, k1, k2, k3, k4):
            setattr(self, name, a + step_size / 6.0 * (p + 2.0 * q + 2.0 * r + s))
        return True
