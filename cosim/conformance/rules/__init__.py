"""All rules. Adding one: write it in the file of its subject; importing this package registers it."""
from . import archive, dynamic, header, structure, units, variables  # noqa: F401
