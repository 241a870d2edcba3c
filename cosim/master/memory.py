"""How much memory there is."""
import contextlib
import math
from pathlib import Path

GROUP = Path("/sys/fs/cgroup")  # what limits a container, where there is such a limit


def free_memory() -> float:
    """Bytes that this process may still use; infinite where nothing tells."""
    free = math.inf
    with contextlib.suppress(OSError, ValueError, KeyError):
        lines = dict(line.split(":") for line in Path("/proc/meminfo").read_text().splitlines())
        free = 1024 * float(lines["MemAvailable"].split()[0])
    with contextlib.suppress(OSError, ValueError, KeyError):  # "max" is no number: no limit
        limit = float((GROUP / "memory.max").read_text())
        used = dict(line.split() for line in (GROUP / "memory.stat").read_text().splitlines())
        free = min(free, limit - float(used["anon"]))
    return free
