"""Parameters of a system fitted to measured flights, from words to a folder of results: what `ahv fit` does."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, isfinite
from typing import Any

import numpy as np
import pyarrow as pa

from ..errors import RunError, UsageError
from ..master.algorithms import method
from ..master.connections import checked_connections
from ..master.fly import tick_count
from ..master.fmu import FmuFile
from ..master.loaded import open_files
from ..master.system import System, Value
from ..master.wiring import Signal, signal
from ..systems.load import Loaded
from ..systems.words import assigned, experiment
from .certainty import CONFIDENCE, Certainty, certainty
from .data import Known, Measured, noise_levels, owner, read_flight
from .flown import Plan, Plans, flying
from .parameters import Parameter, check_apart, parameter
from .search import Fly, Found, Problem, Rows, search, starts

ALGORITHM = "gauss-seidel"
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Subject:
    """What is fitted: a system with what its file suggests, the same with COMPONENT.VARIABLE=VALUE words set, and the
    words of the command that flies it (empty: none); `feeds` tells whether that takes inputs from a table."""
    found: Loaded
    build: Callable[[Sequence[str]], System]
    command: tuple[str, ...] = ()
    feeds: bool = False


@dataclass(frozen=True)
class Asked:
    """A request that was checked. Times in s."""
    subject: Subject
    measured: list[Measured]
    words: list[list[str]]           # what is set for each flight
    parameters: list[Parameter]
    signals: dict[str, Signal]
    levels: np.ndarray               # noise levels, NaN where they are to be found
    plans: Plans
    remarks: list[str]

    @property
    def rows(self) -> Rows:
        """All measured values, flight by flight and signal by signal."""
        names = list(self.signals)
        found = [(v[np.isfinite(v)], names.index(name), k) for k, one in enumerate(self.measured)
                 for name, v in one.signals.items()]
        return Rows(np.concatenate([v for v, _, _ in found]), np.concatenate([np.full(len(v), s) for v, s, _ in found]),
                    np.concatenate([np.full(len(v), k) for v, _, k in found]))


@dataclass(frozen=True)
class Fit:
    """What a fit found: `values` and `intervals_95` by the parameters' names (None: there is none, `summary` says why),
    the `systems` of the flights with these values, and the `summary` that fit.json has.

    `table` is a pyarrow.Table of all rows: flight, time (s), signal, measured, before, after. `finished` is False if a
    flight does not come to its end with the fitted values; `message` says why. `request` has what was asked for.
    """
    values: dict[str, float]
    intervals_95: dict[str, tuple[float, float] | None]
    systems: list[System]
    summary: dict[str, Any] = field(repr=False)
    table: Any = field(repr=False)
    request: Asked = field(repr=False)
    finished: bool
    message: str


def subject_of(found: Loaded) -> Subject:
    """A system from a file."""
    return Subject(found, lambda words: assigned(words, found), ("ahv", "simulate", str(found.path)), feeds=True)


def asked(subject: Subject, data: Sequence[str], parameters: Sequence[str], signals: Sequence[str],
          values: Sequence[str], start: float | None, step: float | None, algorithm: str | None,
          tolerance: float | None, time_limit: float | None) -> Asked:
    """The request, checked before anything flies; see `fit`. Raises UsageError, one sentence."""
    if not data or not parameters:
        raise UsageError("A fit needs a table of measured signals, and a parameter to find: --parameter.")
    for file in data:
        if data.count(file) > 1:
            raise UsageError(f"{file} is given twice.")
    if time_limit is not None and not time_limit > 0:
        raise UsageError(f"--time-limit {time_limit:g} must be a positive number of seconds.")
    if step is not None and not (step > 0 and isfinite(step)):
        raise UsageError(f"--step {step:g} must be a positive number of seconds.")
    if tolerance is not None and not (tolerance > 0 and isfinite(tolerance)):
        raise UsageError(f"--tolerance {tolerance:g} must be a positive number.")
    method(algorithm or ALGORITHM)
    found, owned = subject.found, [owner(word, data) for word in values]
    own = [[word for place, word in owned if place == k] for k in range(len(data))]
    words = [[*(word for place, word in owned if place is None), *mine] for mine in own]
    systems = [subject.build(mine) for mine in words]
    with open_files(systems[0]) as files:
        systems = typed(systems, files)
        known = Known(files, checked_connections(systems[0], files), found.alone)
        levels = noise_levels(signals, known)
        begin = found.system.start if start is None else start
        measured = [read_flight(file, known, levels, begin) for file in data]
        names = list(dict.fromkeys(name for one in measured for name in one.signals))
        for name in levels:
            if name not in names:
                raise UsageError(f"--signal {known.shown([name])[0]}: no data file has such a column.")
        free = [parameter(word, known, data, systems) for word in parameters]
        check_apart(free, own, known, [set(one.inputs.values) if one.inputs else set() for one in measured], data)
        about = {name: about_signal(name, files) for name in names}
    _, _, size, remarks = experiment(found, begin, max(float(one.times[-1]) for one in measured), step)
    plans = [Plan(system, ticks(one, begin, size), {name: one.times[np.isfinite(v)] for name, v in one.signals.items()},
                  one.inputs) for system, one in zip(systems, measured)]
    rows = sum(len(times) for plan in plans for times in plan.wanted.values())
    if rows <= len(free):
        raise UsageError(f"{len(free)} parameters cannot be found from {rows} measured values: more values than "
                         f"parameters are needed.")
    given = np.array([np.nan if (level := levels.get(name)) is None else level for name in names])
    return Asked(subject, measured, words, free, about, given,
                 Plans(plans, algorithm or found.algorithm or ALGORITHM, size, begin,
                       found.tolerance if tolerance is None else tolerance, time_limit),
                 [*remarks, *found.remarks, *(text for one in measured for text in one.remarks)])


def typed(systems: list[System], files: dict[str, FmuFile]) -> list[System]:
    """The systems with values in their variables' types; of values that are alike one object, which a master that is
    reset then knows. Raises UsageError for a value that does not fit."""
    known: dict[tuple[str, str, Value], Value] = {}
    for system in systems:
        for c in system.components:
            for name, value in c.values.items():
                if (c.name, name, value) not in known:
                    known[c.name, name, value] = files[c.name].checked(name, value, c.name)
    return [replace(system, components=tuple(
        c.with_values({name: known[c.name, name, value] for name, value in c.values.items()})
        for c in system.components)) for system in systems]


def about_signal(name: str, files: dict[str, FmuFile]) -> Signal:
    """What the FMU declares of component.variable."""
    component, _, variable = name.partition(".")
    return signal(name, files[component].description, files[component].variables[variable])


def ticks(measured: Measured, start: float, step: float) -> int:
    """Steps of `step` (s) from `start` (s) that reach the last row. Raises UsageError for numbers that do not fit."""
    tick_count(step, start + step, start)
    count = max(1, ceil((float(measured.times[-1]) - start) / step - 1e-6))
    return tick_count(step, start + count * step, start)


def fit(subject: Subject, data: Sequence[str], parameters: Sequence[str], signals: Sequence[str] = (),
        values: Sequence[str] = (), *, start: float | None = None, step: float | None = None,
        algorithm: str | None = None, tolerance: float | None = None, begin_at: int = 1, seed: int = 1,
        workers: int = 0, time_limit: float | None = None, tell: Tell = lambda line: None) -> Fit:
    """Find `parameters` with which the flights of `subject` show what the tables `data` have.

    `parameters` are words of `parameters.FORM`, `signals` NAME[:SIGMA] (none: all columns that are signals), `values`
    [FILE:]COMPONENT.VARIABLE=VALUE. `begin_at` is how many points the search begins at, `seed` that of drawing them.
    `workers` is how many processes fly, 0 for this one; a flight that takes longer than `time_limit` (s) ends its
    process and counts as lost. `tell` is told a line from time to time.

    Raises UsageError for a request that does not fit, RunError if no flight begins with the start values.
    """
    if begin_at < 1:
        raise UsageError(f"--starts {begin_at} is not allowed: it must be 1 or more.")
    request = asked(subject, data, parameters, signals, values, start, step, algorithm, tolerance, time_limit)
    for remark in request.remarks:
        tell(remark)
    with flying(request.plans, workers) as fly:
        return solved(request, fly, begin_at, seed, tell)


def solved(request: Asked, fly: Fly, begin_at: int = 1, seed: int = 1, tell: Tell = lambda line: None) -> Fit:
    """The fit of a checked request, whose flights `fly` flies; see `fit`. Raises RunError if none begins."""
    rows, first = request.rows, np.array([p.start for p in request.parameters])
    problem = Problem(request.parameters, rows, request.levels, fly, tell)
    before = problem.shown([first])[0]
    if np.isnan(before).all():
        raise RunError(problem.lost[0])
    found = [search(problem, point) for point in starts(request.parameters, begin_at, seed)]
    best = min(found, key=lambda one: one.cost)
    ended = [one.message for one in problem.flights([best.point])[0]]
    after = problem.shown([best.point])[0]
    sure = certainty(request.parameters, best, rows, list(request.signals), list(np.isfinite(request.levels)))
    summary = told(request, rows, before, after, found, best, sure, problem)
    low, high = best.point - sure.half_widths, best.point + sure.half_widths
    labels = [p.name for p in request.parameters]
    intervals = {name: (float(a), float(b)) if isfinite(a) else None for name, a, b in zip(labels, low, high)}
    systems = [plan.system.with_values({p.target: float(x) for p, x in zip(request.parameters, best.point)
                                        if p.flight in (None, k)}) for k, plan in enumerate(request.plans.flights)]
    lost = [f"{one.file}: {text}" for one, text, k in zip(request.measured, ended, range(len(ended)))
            if np.isnan(after[rows.flight == k]).any()]
    return Fit(dict(zip(labels, map(float, best.point))), intervals, systems, {**summary, "message": " ".join(lost)},
               table(request, rows, before, after), request, not lost, " ".join(lost))


def told(request: Asked, rows: Rows, before: np.ndarray, after: np.ndarray, found: list[Found], best: Found,
         sure: Certainty, problem: Problem) -> dict[str, Any]:
    """What fit.json says."""
    plans, names = request.plans, [p.name for p in request.parameters]
    lost = [f"{len(problem.lost)} of {problem.flown} flights did not come to their end, which counts against their "
            f"values; the first said: {problem.lost[0]}"] if problem.lost else []
    doubts = [f"{name} {doubt}." for name, doubt in zip(names, sure.doubts) if doubt]
    parameters = {p.name: {
        "value": float(x), "interval_95": None if np.isnan(half) else [float(x - half), float(x + half)],
        "standard_error": number(error), "start": p.start, "bounds": [number(p.low), number(p.high)], "unit": p.unit,
        "doubt": doubt or None} for p, x, half, error, doubt in zip(
            request.parameters, best.point, sure.half_widths, sure.errors, sure.doubts)}
    signals = {name: {
        "unit": about.unit, "rows": int((rows.signal == s).sum()), "noise": float(best.noise[s]),
        "noise_from": "given" if isfinite(request.levels[s]) else "residuals",
        **{f"rms_{word}": rms((shown - rows.values)[rows.signal == s])
           for word, shown in (("before", before), ("after", after))}}
        for s, (name, about) in enumerate(request.signals.items())}
    flights = [{"file": one.file, "rows": len(one.times), "stop_s": round(plans.start + plan.ticks * plans.step, 12),
                "set": words, "inputs": sorted(one.inputs.values) if one.inputs else [],
                "rms_after": {name: rms((after - rows.values)[(rows.flight == k) & (rows.signal == s)])
                              for s, name in enumerate(request.signals) if name in one.signals}}
               for k, (one, plan, words) in enumerate(zip(request.measured, plans.flights, request.words))]
    return {
        "system": request.subject.found.name, "algorithm": plans.algorithm, "start_s": plans.start,
        "step_s": plans.step, "tolerance": plans.tolerance, "parameters": parameters, "confidence": CONFIDENCE,
        "correlation": {"names": names, "matrix": [[number(x) for x in row] for row in sure.correlation]},
        "signals": signals, "flights": flights, "degrees_of_freedom": sure.freedom,
        "reduced_chi_square": sure.variance, "settled": best.settled,
        "starts": [{"begun_at": dict(zip(names, map(float, one.begun))),
                    "ended_at": dict(zip(names, map(float, one.point))), "cost": one.cost} for one in found],
        "flown": problem.flown, "lost": len(problem.lost), "remarks": request.remarks,
        "warnings": [*doubts, *sure.remarks, *lost]}


def number(value: float) -> float | None:
    """A number as JSON has it: None for one that is not finite."""
    return float(value) if isfinite(value) else None


def rms(errors: np.ndarray) -> float | None:
    """The root of the mean square of what is finite; None if nothing is."""
    there = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(there**2))) if len(there) else None


def table(request: Asked, rows: Rows, before: np.ndarray, after: np.ndarray) -> pa.Table:
    """All rows: flight, time, signal, measured, before, after."""
    names, files = list(request.signals), [one.file for one in request.measured]
    times = np.concatenate([times for plan in request.plans.flights for times in plan.wanted.values()])
    return pa.table({"flight": pa.array([files[k] for k in rows.flight]).dictionary_encode(), "time": times,
                     "signal": pa.array([names[s] for s in rows.signal]).dictionary_encode(), "measured": rows.values,
                     "before": before, "after": after})
