"""A system linearised about its equilibrium, or one FMU about a point, from the files: poles, zeros, margins."""
from .alone import linearize_fmu as linearize_fmu
from .report import linearize as linearize
