"""From a campaign file and the FMUs to what is flown. All checks that need no flight are made here."""
import hashlib
import json
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import create_model

from ..errors import UsageError, nearest
from ..master.algorithms import method
from ..master.connections import checked_connections, recorded_names
from ..master.fly import tick_count
from ..master.loaded import open_files
from ..master.measures import parse
from ..master.system import System, Value
from ..yaml_file import Source
from .code import CODE
from .criteria import check_measures
from .dispersions import (
    Fmus,
    all_draws,
    all_mixings,
    checked,
    constants,
    opened,
    run_count,
    with_measured,
)
from .labels import Label, labels_of
from .rare_rules import check_rare, towards, version, whole_tasks
from .samples import Samples
from .sampling import Draw, Sampler, free
from .spec import Campaign
from .subject import Figure, Measure, Subject, SystemSubject, TakeCourse, nothing, signal

# Of these the draws of a run depend on the number of runs. A campaign of any other sampling can grow.
WHOLE_ONLY = {"latin-hypercube": "A Latin hypercube divides each range into as many strata as there are runs",
              "grid": "A grid has a run for each of its points"}
TICKS_PER_TASK, MOST_PER_TASK, LEAST_TASKS = 200_000, 200, 16
IF_GIVEN = ("metrics", "rare", "samples", "stop_when")  # fields that campaign.json has only where the file has them


@dataclass(frozen=True)
class Job:
    """What a worker has to know: the same for every run."""
    key: str                              # differs when anything here does
    systems: dict[str, System]            # of each variant; the FMUs are SHA256/FILE.fmu, wherever the worker has them
    record: dict[str, list[str]]
    step: float
    ticks: int
    algorithm: str
    success: dict[str, str]
    timeout_s: float
    draws: dict[str, tuple[Draw, ...]]    # of each variant: relative draws multiply its own nominal values
    sampler: Sampler
    keep_share: float                     # of the runs: their signals
    most_failures: float                  # of each variant: the first so many keep their signals
    decimate: int
    code: dict[str, str]                  # that flies it
    start: float = 0.0                    # s
    tolerance: float | None = None
    metrics: dict[str, str] = field(default_factory=dict)     # of the file
    over_time: dict[str, str] = field(default_factory=dict)   # name -> expression
    measure: Measure = nothing            # the subject's own metrics
    course: TakeCourse = signal           # of what is drawn over time
    towards: tuple[str, ...] = ()         # criteria of which the margin is wanted


@dataclass(frozen=True)
class OwnFigure:
    """What pages say of a metric of the campaign file."""
    unit: str
    headline: str


@dataclass(frozen=True)
class Plan:
    """A campaign that has been checked; times in s."""
    source: Source
    campaign: Campaign
    subject: Subject
    constants: dict[str, Value]           # what dispersions set without drawing it
    job: Job
    fmus: dict[str, Path]                 # SHA256/FILE.fmu -> the file
    fingerprint: dict[str, Any]           # what determines the rows
    runs_per_task: int
    labels: dict[str, Label]              # of what is drawn and what is recorded

    @property
    def path(self) -> Path:
        """The campaign file."""
        return self.source.path

    @property
    def laws(self) -> list[str]:
        """The names of the variants, in the order of the file."""
        return list(self.job.systems)

    @property
    def draws(self) -> dict[str, tuple[Draw, ...]]:
        """The draws of each variant."""
        return self.job.draws

    @property
    def stop(self) -> float:
        """The end of a run, s."""
        return self.subject.stop

    @property
    def metrics(self) -> dict[str, Figure]:
        """All metrics, in the order of the table's columns."""
        return {**self.subject.metrics, **{name: OwnFigure("", name) for name in self.campaign.metrics}}

    @property
    def headlines(self) -> list[str]:
        """The metrics that variants are judged by."""
        return [name for name, metric in self.metrics.items() if metric.headline]

    @property
    def described(self) -> str:
        """The text of campaign.json."""
        return json.dumps({"kind": "campaign", **self.fingerprint}, indent=2) + "\n"

    @property
    def worst_by(self) -> str | None:
        """The metric by which the report ranks runs; None if there is no metric at all."""
        used = (n for text in self.campaign.success.values() for n in parse(text).names if n in self.metrics)
        return self.campaign.worst_by or next(used, self.subject.worst_by or next(iter(self.metrics), None))


def load(path: Path, *subjects: type[Subject]) -> Plan:
    """The campaign in the file at `path`, of any system or of one of `subjects`.

    Raises UsageError, with line and field, for the first thing that is wrong.
    """
    source = Source(path, "campaign file")
    campaign, subject = read(source, *subjects)
    return make(campaign, source, subject)


def read(source: Source, *subjects: type[Subject]) -> tuple[Campaign, type[Subject]]:
    """What a campaign file says, and what kind of subject it is of. Raises UsageError for a field that is wrong."""
    kinds: list[type[Subject]] = [*subjects, SystemSubject]
    given = source.data if isinstance(source.data, dict) else {}
    named = [kind for kind in kinds if kind.field in given]
    if len(named) > 1:
        source.fail((named[1].field,), f"either {' or '.join(kind.field for kind in named)} is wanted, not both")
    subject = named[0] if named else kinds[0]
    for other in kinds:
        for name in given:
            if named and name in other.fields.model_fields and name not in subject.fields.model_fields:
                source.fail((name,), f"this belongs to {other.field}, and the file has {subject.field}")
    if given and not named:
        known = dict.fromkeys(name for kind in kinds for name in (*Campaign.model_fields, *kind.fields.model_fields))
        for name in given:
            if name not in known:
                near = nearest(str(name), known)
                source.fail((name,), f"there is no such field{f'; did you mean {near}?' if near else ''}")
        source.fail((), f"{' or '.join(kind.field for kind in kinds)} is missing")
    bases: tuple[Any, ...] = (Campaign, subject.fields)
    model: type[Campaign] = create_model("CampaignFile", __base__=bases)
    campaign = source.load(model)
    for name, why in campaign.out_of_place():
        source.fail((name,), why)
    return campaign, subject


def make(campaign: Campaign, source: Source, kind: type[Subject]) -> Plan:
    """The plan of a campaign. Raises UsageError, with line and field, for what does not fit the FMUs."""
    check_stop_when(source, campaign)
    subject = kind(campaign, source)
    with source.at(next((name for name in ("stop", "start", "step") if name in source.data), subject.field)):
        ticks = tick_count(subject.step, subject.stop, subject.start)
    with source.at("algorithm"):
        method(subject.algorithm)
    campaign, hashes = with_measured(source, written := campaign)
    samples: Samples | None = None
    systems, record, draws, fmus = {}, {}, {}, {}
    signals: set[str] = set()
    labels: dict[str, Label] = {}
    for variant, system in subject.systems.items():
        with open_files(system) as files:
            driven = check_values(source, campaign, subject, variant, system, files)
            samples = samples or opened(source, campaign, files)
            draws[variant] = all_draws(source, campaign, system, files, driven, samples)
            signals |= recorded_names(system, dict(files), ["*"])
            record[variant] = recorded(source, campaign, subject, system, files)
            labels |= labels_of([*(d.name for d in draws[variant]), *record[variant]], files)
            fixed = constants(source, campaign, files)
            system = system.with_values(fixed)
            stored = {c.name: f"{files[c.name].sha256}/{c.fmu.name}" for c in system.components}
            python = any((file.folder / "resources" / "slavemodule.txt").is_file() for file in files.values())
        fmus.update({stored[c.name]: c.fmu for c in system.components})
        systems[variant] = replace(system, components=tuple(
            replace(c, fmu=Path(stored[c.name])) for c in system.components))
    first = draws[next(iter(systems))]
    check_measures(source, campaign, subject, signals, [d.name for d in first])
    check_rare(source, campaign, draws)
    runs = run_count(source, campaign, samples, first)
    written, campaign = (c.model_copy(update={"runs": runs}) for c in (written, campaign))
    sampler = Sampler(campaign.sampling, campaign.seed, runs, len(free(first)), all_mixings(source, campaign, first),
                      samples)
    runs_per_task = campaign.runs_per_task or task_size(runs, ticks * len(systems), python)
    if campaign.rare:
        runs_per_task = whole_tasks(campaign.rare, runs_per_task)
    if samples is not None:
        hashes[samples.file] = samples.sha256
        fmus[samples.stored] = samples.path
    fingerprint = {
        **written.model_dump(mode="json", exclude={"name", "worst_by", *(n for n in IF_GIVEN
                                                                         if n not in campaign.model_fields_set)}),
        **({"files": hashes} if hashes else {}), **subject.said, "runs_per_task": runs_per_task,
        "fmus": {variant: {c.name: str(c.fmu) for c in s.components} for variant, s in systems.items()}, "code": CODE,
        **({"openturns": version()} if campaign.rare else {})}
    job = Job(key_of(fingerprint), systems, record, subject.step, ticks, subject.algorithm, campaign.success,
              campaign.timeout_s, draws, sampler, campaign.signals.share, campaign.signals.most_failures,
              campaign.signals.decimate, CODE, subject.start, subject.tolerance, campaign.metrics,
              {name: expression for name, (_, expression) in subject.over_time.items()}, subject.measure,
              subject.course, towards(campaign))
    return Plan(source, campaign, subject, fixed, job, fmus, fingerprint, runs_per_task, labels)


def key_of(fingerprint: dict[str, Any]) -> str:
    """The key of a campaign: it differs when anything does that determines a row. `kind` is no part of it, nor is the
    number of runs where a campaign can grow."""
    without = {"kind", "runs_per_task"} | (set() if fingerprint.get("sampling") in WHOLE_ONLY else {"runs"})
    text = json.dumps({name: value for name, value in fingerprint.items() if name not in without}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def check_values(source: Source, campaign: Campaign, subject: Subject, variant: str, system: System, files: Fmus
                 ) -> dict[str, str]:
    """Which inputs are driven by which outputs. Raises UsageError, with line and field, for values and connections that
    the FMUs do not allow."""
    for name, value in campaign.set.items():
        with source.at("set", name):
            checked(files, name, value)
    for name, value in subject.sets[variant].items():
        with source.at(*subject.places[variant], "set", name):
            checked(files, name, value)
    for component in system.components:
        for variable, value in component.values.items():
            with source.at(subject.field):
                checked(files, f"{component.name}.{variable}", value)
    with source.at(*subject.wires[variant]):
        return {target: link.source for target, link in checked_connections(system, dict(files)).items()}


def recorded(source: Source, campaign: Campaign, subject: Subject, system: System, files: Fmus) -> list[str]:
    """What is recorded of a variant: what the metrics and criteria need, and what the file asks for where this variant
    has it."""
    known = dict(files)
    chosen = subject.needed(recorded_names(system, known, None))
    measured = {n for text in (*campaign.metrics.values(), *campaign.success.values()) for n in parse(text).names}
    chosen |= measured & recorded_names(system, known, ["*"])
    for pattern in campaign.signals.record:
        try:
            chosen |= recorded_names(system, known, [pattern])
        except UsageError:
            if len(subject.systems) == 1:
                source.fail(("signals", "record"), f"{pattern} fits no numeric variable")
    return sorted(chosen)


def check_stop_when(source: Source, campaign: Campaign) -> None:
    """Raises UsageError, with line and field, for a rule that cannot end this campaign."""
    if (rule := campaign.stop_when) is None:
        return
    if rule.probability not in ("success", *campaign.success):
        source.fail(("stop_when", "probability"), f"{rule.probability} is no criterion; there are "
                    f"{', '.join(dict.fromkeys(('success', *campaign.success)))}")
    other = "samples" if campaign.samples is not None else campaign.sampling
    if other != "random":
        source.fail(("stop_when",), f"it needs sampling: random, not {other}: its confidence is that of independent "
                    "draws")


def task_size(runs: int, ticks: int, python: bool) -> int:
    """Runs of one task: a second or so of work, and tasks enough to share out; `python` FMUs are slow."""
    per_task = TICKS_PER_TASK if not python else TICKS_PER_TASK // 50
    return max(1, min(per_task // ticks, MOST_PER_TASK, math.ceil(runs / LEAST_TASKS)))
