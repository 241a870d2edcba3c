"""What the child is told about an FMU: its variables, its experiment, and which probes are for it."""
import os
import platform
from math import prod
from pathlib import Path

from ..master.declared import Variable, integer, number
from . import probes  # noqa: F401  (importing the probes registers them)
from .job import Job, Known
from .probes.registry import PROBES
from .rules.structure import is_clocked
from .subject import Fmu

STEPS = 20  # of a run
PATIENCE_S = 8.0  # for repetitions
TOLERANCE = 1e-4  # where the file names none
WITH_CLOCKS = ("load", "free-null", "guid", "event-mode")  # the probes of an FMU with clocks, which nobody ticks
MOST_ELEMENTS = 10_000  # of an array that is read and set
LATE = ("memory", "memory-steps")  # what takes many lives


def host_library(fmu: Fmu) -> Path | None:
    """The FMU's shared library for this machine, or None."""
    host = fmu.version.host
    is_foreign = host == "linux64" and platform.machine() not in ("x86_64", "AMD64")
    suffix = fmu.version.platforms.get(host, (".so",))[0]
    return None if is_foreign else fmu.library(host, suffix)


def make_job(fmu: Fmu, library: Path, time_limit: float, cycles: int) -> Job:
    """What the child needs to know about the FMU."""
    given = {key: number(text) for key, text in fmu.description.experiment.items()}
    start, stop, step = given.get("startTime") or 0.0, given.get("stopTime"), given.get("stepSize")
    has_step = bool(step and step > 0)
    if not step or step <= 0:
        step = (stop - start) / 100 if stop is not None and stop > start else 0.01
    fixed = number((fmu.description.co_simulation or {}).get("fixedInternalStepSize")) or 0.0
    if fixed > 0:  # FMI 3.0: steps should be multiples of it
        step = fixed * max(1, round(step / fixed))
    tolerance = given.get("tolerance") or 0.0
    has_tolerance = 0 < tolerance < 1
    fitting = int((stop - start) / step + 1e-9) if stop is not None and stop > start else STEPS
    steps = max(2, min(STEPS, fitting))  # not beyond the default stop time
    claims = {flag: 1 for flag in fmu.version.flags if fmu.description.claims(flag)}
    resources = fmu.folder / "resources"
    variables = [known_variable(v, v.causality == "output" or v.index in fmu.description.states, fmu.description.flat)
                 for v in fmu.description.variables if v.type and v.reference is not None and not is_clocked(v)]
    order = integer((fmu.description.co_simulation or {}).get("maxOutputDerivativeOrder")) or 0
    return Job(
        library=str(library),
        guid=fmu.description.attributes.get(fmu.version.token, ""),
        resources=f"{resources}{os.sep}" if fmu.description.flat else resources.as_uri(),
        start=start,
        stop=stop,
        step=step,
        has_step=has_step,
        tolerance=tolerance if has_tolerance else TOLERANCE,
        has_tolerance=has_tolerance,
        claims=claims | ({"maxOutputDerivativeOrder": order} if order else {}),
        categories=[c.get("name", "") for c in fmu.description.root.iterfind("LogCategories/Category")],
        variables=[v for v in variables if (v.count or 1) <= MOST_ELEMENTS and v.count != 0],
        probes=sorted(served(fmu), key=lambda name: (not PROBES[name].legal, name in LATE)),  # wrong use comes last
        steps=steps,
        cycles=cycles,
        patience=min(time_limit / 2, PATIENCE_S),
        version=fmu.version.name,
        clocks=clocks_of(fmu),
        fixed_step=fixed,
        until=0.0,
    )


def served(fmu: Fmu) -> list[str]:
    """The probes for the FMU's version, and for clocks where it has some."""
    own = [name for name, one in PROBES.items() if fmu.version.name in one.versions]
    return [name for name in own if name in WITH_CLOCKS] if clocks_of(fmu) else own


def clocks_of(fmu: Fmu) -> str:
    """Which clocks the FMU has: see `Job.clocks`."""
    clocks = [v for v in fmu.description.variables if v.type == "Clock"]
    timed = any(v.causality == "input" and v.resolved("intervalVariability") != "triggered" for v in clocks)
    return "timed" if timed else "triggered" if clocks else ""


def known_variable(v: Variable, counts: bool, is_flat: bool) -> Known:
    """The variable as the probes need it."""
    count = None if v.shape is None else prod(v.shape)
    texts = [v.start] if count is None else v.starts * count if len(v.starts) == 1 else v.starts
    starts = [start_value(v, text) for text in texts]
    if count is not None and len(starts) != count:
        starts = []  # rule array.starts
    return Known(
        name=v.name,
        reference=v.reference or 0,
        base="Int64" if v.type == "Enumeration" and is_flat else v.base,
        causality=v.causality,
        variability=v.variability,
        initial=v.initial,
        start=starts[0] if starts else None,
        low=v.min,
        high=v.max,
        nominal=v.nominal,
        counts=counts,
        items=list(v.items.values()),
        count=count,
        starts=[] if count is None else starts,
    )


def start_value(v: Variable, text: str | None) -> float | int | str | None:
    """One start value as the probes need it."""
    if v.family == "Real":
        return number(text)
    if v.type == "Boolean":
        return None if text is None else int(text.strip() in ("true", "1"))
    if v.type == "Binary":
        return None if text is None else text.strip().lower()
    return text if v.type == "String" else integer(text)
