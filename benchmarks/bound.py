"""The smallest largest altitude error that any controller could have, draw by draw: docs/laws/bound.md.

    .venv/bin/python benchmarks/bound.py --case case1 --draws 100                 (two or three seconds a draw)
    .venv/bin/python benchmarks/bound.py --case case2 --draws 100 --blind 0.1     (three)
    .venv/bin/python benchmarks/bound.py --case case1 --runs 905 1234             (these draws)
    .venv/bin/python benchmarks/bound.py --case case1 --draws 10 --check          (what does not change the bound)

Draw k is run k of the campaign docs/campaigns/CASE.yaml. `--blind known` is a controller that knows everything, also
beforehand; 0.1 is one whose inputs stay as they were for 0.1 s after each jump of the coefficients, and which then
knows everything. Each flight found is flown forward by the FMUs. Rows go to OUT/CASE-seedN.csv, one for each jump, as
they are found; those that are there already are not computed again, so a run can be stopped and continued.
"""
import argparse
import csv
import json
import sys
from collections.abc import Container, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from bound_problem import (
    AFTER,
    GROUPS,
    SMOOTHING,
    SPEED_ERROR,
    STATES,
    TICK,
    Best,
    Values,
    Window,
    best,
    jumps,
    places,
    program,
    references,
    window,
)
from scipy.stats import spearmanr

from cosim.campaign import plan as plans
from cosim.campaign.sampling import draw
from cosim.campaign.statistics import interval
from cosim.errors import UsageError
from cosim.master.algorithms import method
from cosim.master.algorithms.base import Experiment
from cosim.master.loaded import Master, open_files
from cosim.master.recording import Recorder
from cosim.master.system import Component, Connection, System
from cosim.vehicle.campaigns import Laws
from cosim.vehicle.closed_loop import fmu_path
from cosim.vehicle.scenario_model import SCALES
from cosim.yaml_file import Source

ROOT = Path(__file__).parent.parent
CASES = ("case1", "case2")
KNOWN = "known"
MODES = (KNOWN, "0.1", "0.3")
WITHIN = 20.0         # ft
QUANTILES = {"median": 0.5, "p90": 0.9, "p99": 0.99, "max": 1.0}
FLOWN_STEP = 1e-3     # s: communication step of the forward flights
FLOWN_SPAN = 4.0      # s after the jump: nobody steers, and any difference grows by e every 0.6 s
COLUMNS = ("run", "blind", "jump_s", "bound_ft", "flown_ft", "apart_ft", *GROUPS, "iterations", "seconds", "status")


class Draws:
    """The scenarios of a campaign file's runs."""

    def __init__(self, case: str, seed: int | None = None):
        """`case` is one of CASES; `seed` stands for the file's. Raises UsageError for FMUs that are not built."""
        source = Source(ROOT / "docs" / "campaigns" / f"{case}.yaml", "campaign file")
        campaign, _ = plans.read(source, Laws)
        if seed is not None:
            campaign = campaign.model_copy(update={"seed": seed})
        self.plan = plans.make(campaign, source, Laws)
        self.law = self.plan.laws[0]
        scenario = next(c for c in self.plan.job.systems[self.law].components if c.name == "scenario")
        self.fixed = {name: float(value) for name, value in scenario.values.items()}
        self.stop = self.plan.stop
        self.reference = references(self.fixed, self.stop + 30.0)
        self.jumps = jumps(self.fixed, self.stop)

    @property
    def seed(self) -> int:
        """The seed of the draws."""
        return self.plan.campaign.seed

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.plan.campaign.runs

    def values(self, run: int) -> dict[str, float]:
        """The scenario's parameters in a run."""
        drawn = draw(self.plan.draws[self.law], self.plan.job.sampler.uniforms(run))
        return {**self.fixed, **{name.partition(".")[2]: float(value) for name, value in drawn.items()}}


class Forward:
    """Scenario and plant as FMUs, flown with given inputs through the master."""

    def __init__(self) -> None:
        parts = [Component("scenario", fmu_path("native", "AhvScenario")),
                 Component("plant", fmu_path("native", "AhvPlant"))]
        self.system = System(parts, [Connection(f"scenario.{scale}", f"plant.{scale}") for scale in SCALES])
        self.stack = ExitStack()
        files = self.stack.enter_context(open_files(self.system))
        self.master = Master(self.system, files, ["plant.h"])
        self.method = method("gauss-seidel")

    def heights(self, values: Values, w: Window, inputs: np.ndarray) -> np.ndarray:
        """h (ft) at every TICK of the window, its first included, with `inputs` (2, n) held over its intervals; as far
        as these go."""
        start = {f"{name}_start": x for name, x in zip(STATES, w.start.tolist())}
        given = {"scenario": half_a_step_later(values), "plant": {"start_at_trim": False, **start}}
        self.master.reset(System([c.with_values(given[c.name]) for c in self.system.components],
                                 self.system.connections))
        counts = [round(length / FLOWN_STEP) for length in w.lengths[:inputs.shape[1]]]
        recorder = Recorder(self.master.columns)
        experiment = Experiment(float(w.times[0]), FLOWN_STEP, sum(counts), recorder, round(TICK / FLOWN_STEP))
        flier = self.method.algorithm(self.master, self.method.options, experiment)
        plant = self.master.instances[self.master.number["plant"]]
        self.master.initialise(experiment.start, experiment.stop)
        recorder.add(experiment.start, self.master.row())
        for (fuel_ratio, elevator), count in zip(inputs.T.tolist(), counts):
            plant.set({"fuel_ratio": fuel_ratio, "elevator": elevator})
            until = flier.ticks + count
            while flier.ticks < until:
                flier.advance(until - flier.ticks)
        return recorder.finish()[1][:, 0]

    def __enter__(self) -> "Forward":
        return self

    def __exit__(self, *_: object) -> None:
        self.master.close()
        self.stack.close()


def half_a_step_later(values: Values) -> dict[str, float]:
    """The scenario with which the scale that the plant gets for a step, the one of its end, is that of its middle."""
    late = dict(values)
    for scale in SCALES:
        late[f"{scale}_sine_phase"] -= late[f"{scale}_sine_omega"] * FLOWN_STEP / 2
        late[f"{scale}_sine_gate_start"] += FLOWN_STEP / 2
    return late


def compared(draws: Draws, forward: Forward, run: int, w: Window, found: Best) -> tuple[float, float]:
    """(largest altitude error of the forward flight, its largest distance from the flight found), ft."""
    last = int(np.searchsorted(w.times, w.jump + FLOWN_SPAN + TICK / 2))  # so many states, one interval less
    heights = forward.heights(draws.values(run), w, found.inputs[:, :last - 1])
    at = TICK * np.arange(len(heights)) + w.times[0]
    wanted = draws.reference[1, 0, places(at)]
    nodes = places(w.times[:last] - w.times[0])
    return float(np.abs(heights - wanted).max()), float(np.abs(heights[nodes] - found.states[1, :last]).max())


def row(draws: Draws, forward: Forward, run: int, mode: str, jump: float) -> dict[str, Any]:
    """What is found of one jump."""
    w = window(draws.values(run), draws.reference, jump, None if mode == KNOWN else float(mode))
    found = best(w)
    flown, apart = compared(draws, forward, run, w, found)
    first = int(np.searchsorted(w.times, jump - TICK / 2))  # interval after the jump
    return {"run": run, "blind": mode, "jump_s": jump, "bound_ft": round(found.bound, 5), "flown_ft": round(flown, 5),
            "apart_ft": round(apart, 6), **dict(zip(GROUPS, np.round(w.scales[:, 3 * first], 4).tolist())),
            "iterations": found.iterations, "seconds": round(found.seconds, 3), "status": found.status}


# --- rows, kept as they are found --------------------------------------------------------------------------------

def read(path: Path) -> dict[tuple[int, str, float], dict[str, str]]:
    """The rows that are there already by run, kind of controller and jump; a line that was cut off is none."""
    lines = path.read_text().splitlines(keepends=True) if path.is_file() else []
    rows = csv.DictReader(line for line in lines if line.endswith("\n"))
    return {(int(row["run"]), row["blind"], float(row["jump_s"])): row for row in rows}


def compute(draws: Draws, runs: Sequence[int], modes: list[str], path: Path) -> None:
    """Find what is missing of these runs, and add it to the file at `path`."""
    known = read(path)
    missing = [(run, mode, jump) for run in runs for mode in modes for jump in draws.jumps
               if (run, mode, jump) not in known]
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "a+b") as file:
        file.seek(0)
        file.truncate(file.read().rfind(b"\n") + 1)
    with open(path, "a", newline="") as file, Forward() as forward:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if file.tell() == 0:
            writer.writeheader()
        for i, (run, mode, jump) in enumerate(missing, 1):
            writer.writerow(found := row(draws, forward, run, mode, jump))
            file.flush()
            print(f"{i} of {len(missing)}: draw {run}, {mode}, jump at {jump:g} s: {found['bound_ft']:.2f} ft",
                  file=sys.stderr, flush=True)


def bounds(path: Path, mode: str, runs: Container[int] | None = None) -> dict[int, float]:
    """Run -> the largest over its jumps (ft), for those of `runs` of which every jump was solved."""
    rows = {key: r for key, r in read(path).items() if key[1] == mode and (runs is None or key[0] in runs)}
    whole = len({jump for _, _, jump in rows})
    found: dict[int, list[float]] = {}
    for (run, _, _), r in rows.items():
        if r["status"] in Best.FOUND:
            found.setdefault(run, []).append(float(r["bound_ft"]))
    return {run: max(errors) for run, errors in sorted(found.items()) if len(errors) == whole}


def line(path: Path, mode: str, runs: Container[int]) -> dict[str, Any]:
    """The table's line of one kind of controller."""
    errors = np.array(list(bounds(path, mode, runs).values()))
    rows = [r for key, r in read(path).items() if key[1] == mode and key[0] in runs]
    tried = len({r["run"] for r in rows})
    within = int((errors < WITHIN).sum())
    return {
        "blind": mode, "draws": len(errors), "unsolved": tried - len(errors),
        "within_20_ft": within / len(errors), "interval": list(interval(within, len(errors))),
        **{f"{name}_ft": float(np.quantile(errors, q)) for name, q in QUANTILES.items()},
        "seconds_per_draw": sum(float(r["seconds"]) for r in rows) / tried,
        "flown_apart_ft": max(float(r["apart_ft"]) for r in rows),
        "flown_above_ft": max(float(r["flown_ft"]) - float(r["bound_ft"]) for r in rows),
        "rank_correlation": {group: rank_correlation(rows, group) for group in GROUPS},
    }


def rank_correlation(rows: list[dict[str, str]], group: str) -> float | None:
    """Spearman's, of a group's scale after the jump with the bound; None where a draw has several jumps."""
    if len({r["jump_s"] for r in rows}) > 1:
        return None
    return float(spearmanr(*([float(r[name]) for r in rows] for name in (group, "bound_ft"))).statistic)


# --- what the figures do not depend on ---------------------------------------------------------------------------

def check(draws: Draws, runs: Sequence[int], modes: list[str]) -> dict[str, float]:
    """Largest change of the bound (ft) over these runs and the first jumps, for each thing that is changed."""
    changes: dict[str, float] = {}
    for run in runs:
        for mode in modes:
            for jump in draws.jumps[:2]:
                blind = None if mode == KNOWN else float(mode)
                usual = window(draws.values(run), draws.reference, jump, blind)
                long = window(draws.values(run), draws.reference, jump, blind, (*AFTER, (0.1, 20.0)))
                bound = best(usual).bound
                others = {"20 s instead of 10": best(long),
                          "a tenth of the smoothing": program(usual.lengths, smoothing=SMOOTHING / 10).solve(usual),
                          "twice the speed error": program(usual.lengths, speed_error=2 * SPEED_ERROR).solve(usual),
                          **{f"guess {i}": program(usual.lengths).solve(usual, i) for i in (1, 2, 3)}}
                for name, other in others.items():
                    changes[name] = max(changes.get(name, 0.0), abs(other.bound - bound) if other.found else np.inf)
                print(f"draw {run}, {mode}, jump at {jump:g} s: {bound:.4f} ft; largest changes {changes}",
                      file=sys.stderr, flush=True)
    return changes


def main() -> int:
    """The command line; its exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", choices=CASES, default="case1")
    parser.add_argument("--draws", type=int, default=100, help="the first so many runs of the campaign")
    parser.add_argument("--runs", type=int, nargs="+", metavar="K", help="these, instead of the first")
    parser.add_argument("--blind", nargs="+", default=list(MODES), metavar="S", help="known, or seconds")
    parser.add_argument("--seed", type=int, help="instead of the campaign file's")
    parser.add_argument("--out", type=Path, default=Path("results/bound"), metavar="DIR")
    parser.add_argument("--check", action="store_true", help="what the bound does not depend on, instead")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    try:
        draws = Draws(given.case, given.seed)
        checked(draws, given)
    except UsageError as error:
        print(error, file=sys.stderr)
        return 2
    runs = given.runs or range(given.draws)
    said: dict[str, Any] = {"case": given.case, "seed": draws.seed}
    if given.check:
        said["largest_change_ft"] = check(draws, runs, given.blind)
    else:
        path = given.out / f"{given.case}-seed{draws.seed}.csv"
        compute(draws, runs, given.blind, path)
        said |= {"file": str(path), "controllers": [line(path, mode, runs) for mode in given.blind]}
    print(json.dumps(said, indent=None if given.json else 2))
    return 0


def checked(draws: Draws, given: argparse.Namespace) -> None:
    """Raises UsageError for numbers that are not allowed."""
    if not 0 < given.draws <= draws.runs:
        raise UsageError(f"--draws {given.draws} is not allowed: the campaign has 1 to {draws.runs} runs.")
    for run in given.runs or ():
        if not 0 <= run < draws.runs:
            raise UsageError(f"--runs {run} is not allowed: the campaign has runs 0 to {draws.runs - 1}.")
    for word in given.blind:
        try:
            fits = word == KNOWN or 0 <= float(word) <= 1
        except ValueError:
            fits = False
        if not fits:
            raise UsageError(f"--blind {word} is not allowed: it is {KNOWN}, or seconds from 0 to 1.")


if __name__ == "__main__":
    sys.exit(main())
