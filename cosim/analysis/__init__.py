"""A system linearised about its equilibrium, from its FMU files alone: poles, zeros, margins."""
from .report import linearize as linearize
