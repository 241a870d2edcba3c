"""The static rules. Adding one: its line in rules.yaml, and a function in the file of its subject."""
from . import archive, clocks, further, header, naive, structure, units, variables  # noqa: F401
