"""What probes run an FMU with: instances, legal sequences of calls, recorded trajectories, and a place to report to.

A legal life of an instance is that of section 4.2.4: instantiate, set up, initialize, steps, terminate, free. A legal
call that fails raises `CallFailed`, which the child turns into a finding.
"""
import json
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

from ..fmi2 import (
    DISCARD,
    PENDING,
    WARNING,
    Instance,
    Library,
    Mark,
    Value,
    packed_references,
)
from ..fmi3 import TYPES, Instance3, Library3
from ..job import Job, Known
from .compare import BITS, Column, Difference, worst_difference
from .registry import CallFailed, EndedItself, NoInstance, status_name

LONGEST_RUN_S = 2.0
FEWEST_STEPS = 4
ADDRESSES = (".base.lo", ".base.hi")  # how OSMP, of ASAM's OSI, hands over memory
NOISE = 10.0  # a replay may differ by so many times what two fresh instances differ
BASES = {"2.0": ("Real", "Integer", "Boolean", "String"), "3.0": (*TYPES, "Binary")}


Row = dict[str, bytes | list[Value]]  # by type, packed as the FMU gave it, which is compared quickly


class Bench:
    """One loaded FMU in the child process."""

    def __init__(self, job: Job, mark: Mark, answers: int):
        self.job = job
        self.answers = answers
        self.mark = mark
        self.is_over = False  # nothing more can be tested in this process

    @cached_property
    def library(self) -> Library:
        """The loaded library. Raises OSError if it does not load."""
        if self.job.version == "2.0":
            return Library(Path(self.job.library), self.mark)
        counts = {v.reference: v.count for v in self.job.variables if v.count is not None}
        return Library3(Path(self.job.library), self.mark, counts)

    # --- reporting ------------------------------------------------------------------------------------

    def fault(self, rule: str, variable: str, found: str, expected: str, severity: str | None = None,
              impact: str | None = None) -> None:
        """Report a breach of `rule`; `severity` and `impact` if they are milder than the rule's own."""
        self.write_line({"rule": rule, "fault": [variable, found, expected], "severity": severity, "impact": impact})

    def skip(self, what: str, why: str) -> None:
        """Report what is not tested, and why."""
        self.write_line({"skip": [what, why]})

    def note(self, event: str, name: str) -> None:
        """Report that a probe begins or ends."""
        self.write_line({event: name})

    def write_line(self, line: dict[str, object]) -> None:
        """Write one line of JSON for the parent."""
        with open(self.answers, "w", encoding="utf-8", closefd=False) as file:
            file.write(json.dumps(line) + "\n")

    # --- legal lives ----------------------------------------------------------------------------------

    @contextmanager
    def instance(self, logging_on: bool = False) -> Iterator[Instance]:
        """A fresh instance, freed at the end whatever happens."""
        made = self.library.instantiate("checked", self.job.guid, self.job.resources, logging_on)
        if made is None:
            raise NoInstance
        try:
            yield made
        finally:
            made.free()

    def initialize(self, fmu: Instance, stop: float | None = None) -> None:
        """From instantiated to ready to step; `stop` in s. Raises CallFailed."""
        self.expect(fmu.setup(self.job.start, stop), "fmi2SetupExperiment", "in the state instantiated")
        self.expect(fmu.call("EnterInitializationMode"), "fmi2EnterInitializationMode", "after fmi2SetupExperiment")
        self.expect(fmu.call("ExitInitializationMode"), "fmi2ExitInitializationMode", "in initialization mode")

    def step(self, fmu: Instance, number: int, size: float | None = None) -> None:
        """Step number `number`, of `size` s or else the job's step. Raises CallFailed."""
        time = self.time(number)
        status = fmu.step(time, size or self.job.step)
        if status == DISCARD and self.job.version == "2.0":  # FMI 3.0 leaves the time undefined then
            self.check_discard(fmu, time, time + (size or self.job.step))
        self.expect(status, "fmi2DoStep", f"at time {time:g}")
        if isinstance(fmu, Instance3):
            for rule, found, expected in fmu.complaints():
                self.fault(rule, "fmi2DoStep", found, expected)
            if fmu.ends:
                raise EndedItself(f"the FMU ended the simulation at time {fmu.until:g}")

    def check_discard(self, fmu: Instance, begin: float, end: float) -> None:
        """4.2.3: after a discarded step the master asks how far the FMU came."""
        status, reached = fmu.last_successful_time()
        if status > WARNING:
            self.fault("dynamic.discard-status", "fmi2GetRealStatus", f"{status_name(status)} for "
                       "fmi2LastSuccessfulTime after fmi2Discard", "fmi2OK and the time")
        elif not begin - 1e-9 <= reached < end:
            self.fault("dynamic.discard-status", "fmi2GetRealStatus", f"fmi2LastSuccessfulTime {reached:g}",
                       f"a time from {begin:g} to below {end:g}")

    def expect(self, status: int, call: str, where: str) -> None:
        """Raise unless the status says that the legal call worked."""
        if status == PENDING and self.job.claims.get("canRunAsynchronuously"):
            raise CallFailed(call, status, f"{where} (asynchronous steps are not tested)")
        if status > WARNING or status < 0:
            raise CallFailed(call, status, where)

    def time(self, number: int) -> float:
        """The time (s) at which step `number` begins."""
        return self.job.start + number * self.job.step

    @property
    def is_single(self) -> bool:
        """Whether the FMU claims that a process may instantiate it once only."""
        return bool(self.job.claims.get("canBeInstantiatedOnlyOncePerProcess"))

    @property
    def steps(self) -> int:
        """How many steps a run takes."""
        return self.job.steps

    def take_fewer_steps(self, seconds: float) -> None:
        """Shorten all further runs if one takes so many `seconds` that the check would take minutes."""
        fewer = max(FEWEST_STEPS, int(self.steps * LONGEST_RUN_S / seconds)) if seconds > LONGEST_RUN_S else self.steps
        if fewer < self.steps:
            self.skip(f"runs of {self.steps} steps", f"slow: one took {seconds:.1f} s; others have {fewer} steps")
            self.job = replace(self.job, steps=fewer)
            self.write_line({"steps": fewer})

    # --- trajectories ---------------------------------------------------------------------------------

    @cached_property
    def recorded(self) -> list[Known]:
        """What a trajectory holds: everything that the FMU computes. Addresses are no results."""
        return [v for v in self.job.variables if v.causality in ("output", "local", "calculatedParameter")
                and not (v.base == "Integer" and v.name.endswith(ADDRESSES))]

    @cached_property
    def groups(self) -> dict[str, list[Known]]:
        """What a trajectory holds, by type: one call each."""
        found = {base: [v for v in self.recorded if v.base == base] for base in BASES[self.job.version]}
        return {base: group for base, group in found.items() if group}

    @cached_property
    def elements(self) -> dict[str, list[Known]]:
        """The same, with arrays element by element."""
        return {base: [one for v in group for one in v.elements()] for base, group in self.groups.items()}

    @cached_property
    def references(self) -> dict[str, Any]:
        """The value references of each group, as the calls take them."""
        return {base: packed_references([v.reference for v in group]) for base, group in self.groups.items()}

    def row(self, fmu: Instance) -> Row:
        """Read what a trajectory holds, one call per type."""
        read: Row = {}
        for base in self.groups:
            status, read[base] = fmu.get_packed(base, self.references[base], len(self.elements[base]))
            self.expect(status, f"fmi2Get{base}", "after a step")
        return read

    def values(self, row: Row) -> list[tuple[Known, Value]]:
        """The variables of a row with their values."""
        return [pair for base, group in self.elements.items()
                for pair in zip(group, self.library.unpacked(base, row[base]))]

    def advance(self, fmu: Instance, first: int, last: int, excite: bool | None = None) -> list[Row]:
        """Steps number first to last-1, with the test's small movements of the inputs, and what they give."""
        rows = []
        for number in range(first, last):
            if self.excitable if excite is None else excite:
                self.move_inputs(fmu, number)
            self.step(fmu, number)
            rows.append(self.row(fmu))
        return rows

    def run(self, fmu: Instance, excite: bool | None = None) -> list[Row]:
        """A whole run of an initialized or fresh instance, from initialization on."""
        self.initialize(fmu)
        return self.advance(fmu, 0, self.steps, excite)

    def readings(self, fmu: Instance, variables: list[Known]) -> list[tuple[Known, Value]]:
        """Read variables one by one, leaving out what the FMU refuses (which the probe "read" reports)."""
        answers = [(v, fmu.get(v.base, [v.reference])) for v in variables if not self.library.is_corrupt]
        return [pair for v, (status, values) in answers if status <= WARNING for pair in zip(v.elements(), values)]

    def prepare(self) -> None:
        """Make the runs that others are compared with, before a probe has an instance of its own."""
        if not self.is_single:
            _ = self.noise

    @cached_property
    def first_run(self) -> list[Row]:
        """The run that others are compared with."""
        excite = self.excitable
        with self.instance() as fmu:
            return self.run(fmu, excite)

    @cached_property
    def second_run(self) -> list[Row]:
        """The same run of another instance."""
        with self.instance() as fmu:
            return self.run(fmu)

    @cached_property
    def noise(self) -> Difference | None:
        """How far two runs of fresh instances differ."""
        return None if self.is_single else self.difference(self.first_run, self.second_run)

    @property
    def is_deterministic(self) -> bool:
        """Whether two fresh instances agree within the tolerance; without that, replays cannot be judged."""
        return self.noise is None or self.noise.is_explained or not self.noise.counts

    @cached_property
    def excitable(self) -> bool:
        """Whether the FMU runs with small movements of its inputs; if not, runs keep them at their start values."""
        if not self.moving_inputs or self.is_single:
            return False
        try:
            with self.instance() as fmu:
                self.run(fmu, excite=True)
        except CallFailed:
            return False
        return True

    @cached_property
    def moving_inputs(self) -> list[Known]:
        """The inputs of type Real."""
        return [v for v in self.job.variables if v.causality == "input" and v.is_real]

    def move_inputs(self, fmu: Instance, number: int) -> None:
        """Move every Real input by up to a hundredth of its scale around its start value, always in the same way."""
        status = set_all(fmu, self.moving_inputs, lambda v: moved(v, ((number * 7) % 5 - 2) / 2))
        self.expect(status, "fmi2SetReal", "on the inputs")

    def difference(self, first: list[Row], second: list[Row], offset: int = 0) -> Difference | None:
        """Where two runs differ most; None if they are equal to the last bit. `offset` is the first row's step."""
        if first == second:
            return None
        times = [self.time(number + offset + 1) for number in range(min(len(first), len(second)))]
        return worst_difference(self.columns(first, second), times, self.job)

    def columns(self, first: list[Row], second: list[Row]) -> Iterator[Column]:
        """Each variable with its values in two runs, where a value of its type differs."""
        for base, group in self.elements.items():
            one, two = ([row[base] for row in rows] for rows in (first, second))
            if one != two:
                yield from zip(group, *(zip(*(self.library.unpacked(base, x) for x in rows)) for rows in (one, two)))

    def judge(self, rule: str, different: Difference | None, expected: str, where: str = "") -> bool:
        """Report a difference: a breach of `rule` beyond the tolerance, else a warning, or a note where it is rounding.

        Nothing is reported that two fresh instances do not do better. Whether something was reported.
        """
        if different is None:
            return False
        if self.noise and different.share <= NOISE * self.noise.share and different.counts <= self.noise.counts:
            return False
        found = f"{different.text}{where}"
        if different.is_explained:
            found += (f"; at most {different.share:.2g} of the variable's scale, which the tolerance "
                      f"{self.job.tolerance:g} explains")
            self.fault(rule, different.variable, found, expected, "warning" if different.share >= BITS else "note",
                       "formal")
            return True
        found += "" if math.isinf(different.share) else f"; up to {different.share:.2g} of the variable's scale"
        if different.counts:
            self.fault(rule, different.variable, found, expected)
        else:
            found += ", but no output and no state differs by more than the tolerance explains"
            self.fault(rule, different.variable, found, expected, "warning", "formal")
        return True


def set_all(fmu: Instance, variables: list[Known], value: Callable[[Known], Value]) -> int:
    """Set variables, one call for each type, to the values that a function gives for each element; the worst status."""
    worst = 0
    for base in dict.fromkeys(v.base for v in variables):
        group = [v for v in variables if v.base == base]
        worst = max(worst, fmu.set(base, [v.reference for v in group], [value(e) for v in group for e in v.elements()]))
    return worst


def moved(v: Known, share: float) -> float:
    """The start value of a Real moved by `share` hundredths of its scale, kept between min and max."""
    start = float(v.start or 0.0)
    scale = v.nominal or abs(start) or 1.0
    if v.low is not None and v.high is not None:
        scale = min(scale, v.high - v.low)
    value = start + 0.01 * scale * share
    value = value if v.low is None else max(v.low, value)
    return value if v.high is None else min(v.high, value)
