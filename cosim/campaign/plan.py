"""From a campaign file and the FMUs to what is flown. All checks that need no flight are made here."""
import hashlib
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from os.path import isfile
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..master.algorithms import method
from ..master.connections import checked_connections, recorded_names
from ..master.fly import tick_count
from ..master.loaded import open_files
from ..master.system import System, Value
from ..vehicle import scenarios
from ..vehicle.closed_loop import FLAVOURS, ClosedLoop, assignments, closed_loop, names_file
from ..vehicle.metrics import METRICS, needed
from ..vehicle.registry import PLANTS
from ..vehicle.scenarios import Scenario
from ..yaml_file import Source
from .code import CODE
from .criteria import metrics_of
from .dispersions import Fmus, all_draws, all_mixings, checked, constants, opened, run_count, with_measured, with_values
from .samples import Samples
from .sampling import Draw, Sampler, free
from .spec import Campaign, Law

TICKS_PER_TASK, MOST_PER_TASK, LEAST_TASKS = 200_000, 200, 16


@dataclass(frozen=True)
class Job:
    """What a worker has to know: the same for every run."""
    key: str                              # differs when anything here does
    systems: dict[str, System]            # of each law; the FMUs are SHA256/FILE.fmu, wherever the worker has them
    record: dict[str, list[str]]
    step: float
    ticks: int
    algorithm: str
    success: dict[str, str]
    timeout_s: float
    draws: dict[str, tuple[Draw, ...]]    # of each law: relative draws multiply its own nominal values
    sampler: Sampler
    keep_share: float                     # of the runs: their signals
    keep_failures: bool
    decimate: int
    code: dict[str, str]                  # that flies it


@dataclass(frozen=True)
class Plan:
    """A campaign that has been checked; times in s."""
    source: Source
    campaign: Campaign
    scenario: Scenario
    stop: float
    loops: dict[str, ClosedLoop]          # of each law, before anything is drawn
    constants: dict[str, Value]           # what dispersions set without drawing it
    job: Job
    fmus: dict[str, Path]                 # SHA256/FILE.fmu -> the file
    fingerprint: dict[str, Any]           # what determines the rows
    runs_per_task: int

    @property
    def path(self) -> Path:
        """The campaign file."""
        return self.source.path

    @property
    def laws(self) -> list[str]:
        """The names of the laws, in the order of the file."""
        return list(self.job.systems)

    @property
    def draws(self) -> dict[str, tuple[Draw, ...]]:
        """The draws of each law."""
        return self.job.draws

    @property
    def scenario_word(self) -> str:
        """The scenario as `ahv run` takes it."""
        return beside(self.path, self.campaign.scenario)

    @property
    def described(self) -> str:
        """The text of campaign.json."""
        return json.dumps({"kind": "campaign", **self.fingerprint}, indent=2) + "\n"

    @property
    def worst_by(self) -> str:
        """The metric by which the report ranks runs."""
        return self.campaign.worst_by or next(iter(n for text in self.campaign.success.values()
                                                   for n in metrics_of(text)), "altitude_error_ft.max_abs")

    def batches(self) -> Iterator[tuple[int, int]]:
        """First and past-the-last run of each task."""
        for first in range(0, self.campaign.runs, self.runs_per_task):
            yield first, min(first + self.runs_per_task, self.campaign.runs)


def load(path: Path) -> Plan:
    """The campaign in the file at `path`. Raises UsageError, with line and field, for the first thing that is wrong."""
    source = Source(path, "campaign file")
    return make(source.load(Campaign), source)


def make(campaign: Campaign, source: Source) -> Plan:
    """The plan of a campaign. Raises UsageError, with line and field, for what does not fit the FMUs."""
    for field, allowed in (("flavour", FLAVOURS), ("worst_by", (None, *METRICS))):
        if (given := getattr(campaign, field)) not in allowed:
            source.fail((field,), f"there is no {given}; there are {', '.join(filter(None, allowed))}")
    if campaign.plant not in PLANTS and not names_file(campaign.plant):
        source.fail(("plant",), f"there is no {campaign.plant}; there are {', '.join(PLANTS)}, or a FILE.fmu")
    with source.at("scenario"):
        scenario = scenarios.load(beside(source.path, campaign.scenario))
    stop = campaign.stop or scenario.stop
    with source.at("stop" if campaign.stop else "step"):
        ticks = tick_count(campaign.step, stop)
    with source.at("algorithm"):
        method(campaign.algorithm)
    campaign, hashes = with_measured(source, written := campaign)
    samples: Samples | None = None
    systems, record, draws, fmus, loops = {}, {}, {}, {}, {}
    for i, law in enumerate(campaign.controllers):
        with source.at("controllers", i):
            loop = loop_of(campaign, scenario, law, source.path.parent)
            system, loops[law.name] = loop.system, loop
        with open_files(system) as files:
            check_values(source, campaign, law, i, system, files)
            samples = samples or opened(source, campaign, files)
            draws[law.name] = all_draws(source, campaign, system, files, samples)
            record[law.name] = recorded(source, campaign, system, files)
            fixed = constants(source, campaign, files)
            system = with_values(system, fixed)
            stored = {c.name: f"{files[c.name].sha256}/{c.fmu.name}" for c in system.components}
        fmus.update({stored[c.name]: c.fmu for c in system.components})
        systems[law.name] = replace(system, components=tuple(
            replace(c, fmu=Path(stored[c.name])) for c in system.components))
    first = draws[campaign.controllers[0].name]
    written, campaign = (c.model_copy(update={"runs": run_count(source, campaign, samples, first)})
                         for c in (written, campaign))
    sampler = Sampler(campaign.sampling, campaign.seed, campaign.runs, len(free(first)),
                      all_mixings(source, campaign, first), samples)
    runs_per_task = campaign.runs_per_task or task_size(campaign, ticks * len(systems))
    if samples is not None:
        hashes[samples.file] = samples.sha256
        fmus[samples.stored] = samples.path
    fingerprint = {
        **written.model_dump(mode="json", exclude={"name", "worst_by"}), "scenario": scenario.model_dump(mode="json"),
        "stop": stop, "runs_per_task": runs_per_task,
        "fmus": {law: {c.name: str(c.fmu) for c in s.components} for law, s in systems.items()}, "code": CODE}
    if hashes:
        fingerprint["files"] = hashes
    job = Job(key_of(fingerprint), systems, record, campaign.step, ticks, campaign.algorithm, campaign.success,
              campaign.timeout_s, draws, sampler, campaign.signals.share, campaign.signals.failures,
              campaign.signals.decimate, CODE)
    return Plan(source, campaign, scenario, stop, loops, fixed, job, fmus, fingerprint, runs_per_task)


def key_of(fingerprint: dict[str, Any]) -> str:
    """The key of a campaign: it differs when anything does that determines the rows. `kind` is no part of it."""
    text = json.dumps({name: value for name, value in fingerprint.items() if name != "kind"}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def beside(path: Path, scenario: str) -> str:
    """`scenario`, or the path of the file of that name beside the campaign file at `path`."""
    file = path.parent / scenario
    return str(file.resolve()) if scenario not in scenarios.BUILT_IN and isfile(file) else scenario


def loop_of(campaign: Campaign, scenario: Scenario, law: Law, folder: Path) -> ClosedLoop:
    """The closed loop of a law. Raises UsageError for a name that is not known."""
    presets = {**campaign.presets, **({"controller": law.preset} if law.preset else {})}
    values = assignments([f"{name}={value}" for name, value in {**campaign.set, **law.set}.items()])
    return closed_loop(scenario, law.law, campaign.plant, campaign.flavour, presets, values, folder=folder)


def check_values(source: Source, campaign: Campaign, law: Law, number: int, system: System, files: Fmus) -> None:
    """Raises UsageError, with line and field, for values that the FMUs do not allow."""
    for name, value in campaign.set.items():
        with source.at("set", name):
            checked(files, name, value)
    for name, value in law.set.items():
        with source.at("controllers", number, "set", name):
            checked(files, name, value)
    for component in system.components:
        for variable, value in component.values.items():
            with source.at("scenario"):
                checked(files, f"{component.name}.{variable}", value)
    with source.at("plant"):
        checked_connections(system, dict(files))


def recorded(source: Source, campaign: Campaign, system: System, files: Fmus) -> list[str]:
    """What is recorded of a law: what the metrics need, and what the file asks for where this law has it."""
    known = dict(files)
    chosen = needed(recorded_names(system, known, None))
    for pattern in campaign.signals.record:
        try:
            chosen |= recorded_names(system, known, [pattern])
        except UsageError:
            if len(campaign.controllers) == 1:
                source.fail(("signals", "record"), f"{pattern} fits no numeric variable")
    return sorted(chosen)


def task_size(campaign: Campaign, ticks: int) -> int:
    """Runs of one task: a second or so of work, and tasks enough to share out."""
    per_task = TICKS_PER_TASK if campaign.flavour != "python" else TICKS_PER_TASK // 50
    return max(1, min(per_task // ticks, MOST_PER_TASK, math.ceil(campaign.runs / LEAST_TASKS)))
