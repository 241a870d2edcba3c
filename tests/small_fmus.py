"""The small FMU of benchmarks/small.c, for tests: `small.build`, `small.pair`, `small.ring`."""
import importlib.util
from pathlib import Path

_spec = importlib.util.spec_from_file_location("small", Path(__file__).parent.parent / "benchmarks" / "small.py")
assert _spec is not None and _spec.loader is not None
small = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(small)
