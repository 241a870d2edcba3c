"""A system linearised about its equilibrium, from its FMU files alone: poles, zeros, margins."""
from .linearize import linearize as linearize
