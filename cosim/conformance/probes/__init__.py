"""All probes. Adding one: write it in the file of its subject; importing this package registers it."""
from . import faults, life, memory, modes, naive, state  # noqa: F401
