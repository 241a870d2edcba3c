"""What a Dask worker does: it keeps FMU files by their hash, keeps systems loaded, and flies batches of runs."""
import faulthandler
import hashlib
import os
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from distributed.diagnostics.plugin import WorkerPlugin

from ..errors import RunError, UsageError
from ..master.algorithms import method
from ..master.course import Course
from ..master.flight import Flight
from ..master.fly import fly_loaded
from ..master.kept import KeptSystems
from ..master.loaded import Master
from ..master.recording import Whole
from ..master.system import System, Value
from ..master.whole_file import whole
from ..temporary import FULL
from .code import CODE, differences
from .criteria import courses as signals_of
from .criteria import judged
from .margin import of_flight
from .plan import Job
from .sampling import drawn, keeps_signals

ENVELOPE_RUNS, ENVELOPE_POINTS = 2000, 100  # the first runs, whose errors over time are kept
PATIENCE_S = 5.0  # a call that outlasts the timeout by this ends the worker


@dataclass(frozen=True)
class Request:
    """One run to fly."""
    run: int
    law: str
    drawn: dict[str, Value]   # by the draws' names
    values: dict[str, Value]  # what is set
    keep: bool      # its signals, whatever it shows
    envelope: bool  # its errors over time


@dataclass
class Outcome:
    """What a run showed: a row's numbers, errors over time at ENVELOPE_POINTS + 1 times at most, signals if wanted."""
    request: Request
    status: str  # finished, departed (an FMU failed), timed-out, error (did not start), crashed (with its worker)
    message: str = ""
    ticks: int = 0
    departed_at_s: float | None = None
    metrics: dict[str, float] = field(default_factory=dict)
    success: dict[str, bool] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)  # of criteria without a value: why
    margin: float | None = None  # of what a campaign of rare failures flies towards
    errors: dict[str, np.ndarray] | None = None
    signals: dict[str, np.ndarray] | None = None

    @property
    def succeeded(self) -> bool:
        """Whether the run reached the end and met every criterion."""
        return self.status == "finished" and all(self.success.values())


def requests(job: Job, first: int, last: int, points: np.ndarray | None = None) -> Iterator[Request]:
    """Runs first ... last - 1, of each law; at `points` of the unit cube, else at the sampler's."""
    found = zip(*(drawn(job.sampler, draws, first, last, points) for draws in job.draws.values()))
    for k, by_law in zip(range(first, last), found):
        keep = keeps_signals(job.sampler.seed, k, job.keep_share)
        for (law, draws), row in zip(job.draws.items(), by_law):
            values = {target: row[d.name] for d in draws for target in d.targets}
            yield Request(k, law, row, values, keep, k < ENVELOPE_RUNS)


class SendJob(WorkerPlugin):
    """Dask gives the job to every worker once, also to those that join later. It is not part of the tasks because a
    scheduler (2026.8) keeps what they carry."""

    def __init__(self, job: Job):
        self.job = job
        self.name = f"ahv-job-{job.key}"

    def setup(self, worker: Any) -> None:
        """Keep the job in the worker's process."""
        JOBS[self.job.key] = replace(self.job, sampler=self.job.sampler.placed(work_folder(worker)))


class SendFmu(WorkerPlugin):
    """Dask gives an FMU file to every worker once, also to those that join later."""

    def __init__(self, stored: str, content: bytes):
        self.stored, self.content = stored, content
        self.name = plugin_name(stored)

    def setup(self, worker: Any) -> None:
        """Write the file into the worker's folder."""
        keep(work_folder(worker), self.stored, self.content)


def plugin_name(stored: str) -> str:
    """The Dask name of the plugin that sends a file."""
    return f"ahv-fmu-{stored}"


def work_folder(worker: Any) -> Path:
    """Where a worker keeps FMU files."""
    return Path(worker.local_directory) / "ahv_fmus"


def keep(folder: Path, stored: str, content: bytes) -> None:
    """Write `content` to `folder` / `stored`, which is SHA256/NAME.fmu. Raises RunError if its hash is another."""
    if hashlib.sha256(content).hexdigest() != stored.partition("/")[0]:
        raise RunError(f"{stored} arrived with another content.")
    path = folder / stored
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole(path) as partial:
            partial.write_bytes(content)


class OtherCode(RunError):
    """This worker has other code than the campaign's client."""

    def __init__(self, sentence: str, address: str):
        super().__init__(sentence, address)

    def __str__(self) -> str:
        return str(self.args[0])


class OutOfTime(RunError):
    """A run took longer than the campaign allows."""


class LoadedSystems:
    """The systems of one job, loaded when first flown and then reset."""

    def __init__(self, job: Job, folder: Path):
        self.job, self.folder = job, folder
        self.kept = KeptSystems()
        self.recorders: dict[str, Whole] = {}

    def system(self, law: str, values: dict[str, Value]) -> System:
        """The system of a law with `values`, its FMUs in this worker's folder."""
        system = self.job.systems[law].with_values(values)
        return replace(system, components=tuple(replace(c, fmu=self.folder / c.fmu) for c in system.components))

    def ready(self, law: str, values: dict[str, Value]) -> Master:
        """A master that is ready to initialise with these values. Raises UsageError or RunError if it cannot be."""
        system = self.system(law, values)
        tempfile.tempdir = str(self.folder)  # extracted there, too
        try:
            return self.kept.ready(law, system, record=self.job.record[law], tolerance=self.job.tolerance)
        finally:
            tempfile.tempdir = None

    def close(self) -> None:
        """Unload all systems."""
        self.kept.close()

    def fly(self, request: Request) -> Outcome:
        """Fly one run; failures of any kind are outcomes, not exceptions. Only a full disk raises RunError."""
        began = time.monotonic()
        late: list[bool] = []

        def check_time(_: float) -> None:
            if time.monotonic() - began > self.job.timeout_s:
                late.append(True)
                raise OutOfTime(f"Took longer than timeout_s = {self.job.timeout_s:g} s.")

        try:
            master = self.ready(request.law, request.values)
            if request.law not in self.recorders:
                self.recorders[request.law] = Whole(master.columns, self.job.ticks + 2)
            flight = fly_loaded(master, method(self.job.algorithm), self.job.step, self.job.ticks, check_time,
                                recorder=self.recorders[request.law].restart(), start=self.job.start)
        except Exception as error:
            if disk_is_full(error):
                raise RunError(f"The disk with {self.folder} is full.") from None
            if isinstance(error, RunError | UsageError):
                return Outcome(request, "error", str(error))
            self.kept.drop(request.law)
            return Outcome(request, "error", f"{type(error).__name__}: {error}")
        finally:
            self.kept.drop_dead()
        status = "finished" if flight.finished else "timed-out" if late else "departed"
        return self.outcome(request, flight, status)

    def outcome(self, request: Request, flight: Flight, status: str) -> Outcome:
        """What a flight shows of the request."""
        metrics, success, reasons = judged(self.job.measure, self.job.metrics, self.job.success, flight)
        ended = None if flight.finished else flight.reached
        margin = None
        if self.job.towards and status != "timed-out":  # which says nothing of the system
            margin = of_flight({name: self.job.success[name] for name in self.job.towards}, success,
                               signals_of(flight), metrics, None if flight.finished else flight.ticks / self.job.ticks)
        result = Outcome(request, status, flight.message, flight.ticks, ended, metrics, success, reasons, margin)
        if request.envelope and self.job.over_time:
            courses = {name: self.job.course(flight, text) for name, text in self.job.over_time.items()}
            result.errors = errors_over_time(courses, self.job.step, self.job.ticks, self.job.start)
        if request.keep or (self.job.most_failures and not result.succeeded):
            rows = sorted({*range(0, len(flight.time), self.job.decimate), len(flight.time) - 1})
            result.signals = {"time": flight.time[rows],
                              **{c.name: flight.signals[rows, i].copy() for i, c in enumerate(flight.columns)}}
        return result


def disk_is_full(error: BaseException | None) -> bool:
    """Whether an error, or what led to it, is that of a full disk: our trouble, not the run's."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in FULL:
            return True
        error = error.__context__
    return False


def errors_over_time(courses: Mapping[str, Course], step: float, ticks: int, start: float = 0.0
                     ) -> dict[str, np.ndarray]:
    """Courses at fixed times (s), shares of all `ticks` of `step` seconds, as far as the flight came."""
    times = start + step * np.unique(np.linspace(0, ticks, ENVELOPE_POINTS + 1).round())
    times = times[times <= min(one.time[-1] for one in courses.values())]
    return {"time": times, **{name: one.at(times).astype(np.float32) for name, one in courses.items()}}


JOBS: dict[str, Job] = {}
LOADED: list[LoadedSystems] = []     # of this process; one at a time
TURN = threading.Lock()        # FMUs fly one at a time in a process, however many threads Dask gives it
NOWHERE = open(os.devnull, "w")  # noqa: SIM115


def loaded(key: str) -> LoadedSystems:
    """The systems of the job `key`; those of another job are unloaded. Raises OtherCode if that code is not ours."""
    from distributed import get_worker

    if unlike := differences(CODE, JOBS[key].code):
        address = get_worker().address
        raise OtherCode(refusal(address, unlike), address)
    if not LOADED or LOADED[0].job.key != key:
        for other in LOADED:
            other.close()
        LOADED[:] = [LoadedSystems(JOBS[key], work_folder(get_worker()))]
    return LOADED[0]


def refusal(address: str, unlike: str) -> str:
    """The sentence about a worker with other code."""
    return f"The worker at {address} has other code and may not fly: {unlike}."


def fly_batch(key: str, first: int, last: int, positions: list[int] | None = None,
              points: np.ndarray | None = None) -> list[Outcome]:
    """Fly runs first ... last - 1 of the job `key`, one after the other, or those of them at `positions`; `points` as
    in `requests`."""
    asked = list(requests(JOBS[key], first, last, points))
    with TURN:
        flown = (guarded(loaded(key), asked[i]) for i in (range(len(asked)) if positions is None else positions))
        return list(first_failures(flown, JOBS[key].most_failures))


def first_failures(outcomes: Iterable[Outcome], most: float) -> Iterator[Outcome]:
    """The outcomes, without the signals of failures after the first `most` of each law."""
    seen: Counter[str] = Counter()
    for outcome in outcomes:
        if outcome.signals is not None and not outcome.succeeded:
            seen[outcome.request.law] += 1
            if seen[outcome.request.law] > most and not outcome.request.keep:
                outcome.signals = None
        yield outcome


def fly_nominal(key: str, law: str) -> Outcome:
    """Fly a law of the job `key` with nothing drawn; no signals."""
    with TURN:
        return replace(guarded(loaded(key), Request(-1, law, {}, {}, keep=False, envelope=False)), signals=None)


def guarded(systems: LoadedSystems, request: Request) -> Outcome:
    """Fly one run. An FMU call that does not return ends this process: it cannot be ended otherwise."""
    faulthandler.dump_traceback_later(systems.job.timeout_s + PATIENCE_S, exit=True, file=NOWHERE)
    try:
        return systems.fly(request)
    finally:
        faulthandler.cancel_dump_traceback_later()
