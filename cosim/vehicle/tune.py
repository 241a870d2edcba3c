"""Tunes a control law's gains for uncertain vehicles: what `ahv tune` does.

CMA-ES (Hansen) looks for the gains of least cost on the training draws. From time to time what it has found flies test
draws, and the gains that are best there are the result. At the end that flies fresh draws, once, beside the preset that
the search began with. What is flown and what it costs: `tune_flights`.
"""
import json
import math
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RunError, UsageError
from ..master.fmu import FmuFile
from ..master.folder import claimed
from ..master.system import System
from ..master.whole_file import whole
from ..processes import as_worker
from . import scenarios
from .closed_loop import choice, closed_loop
from .registry import LAWS
from .tune_flights import QUICK, SETS, Bench, Figures, Flown, vehicles

LARGEST_SIGMA = 100.0  # of a logarithm: a factor of 1e43
CHECK_EVERY = 10   # generations between two flights of the test draws
WITHIN_FT = 20.0
DIGITS = 4         # of a gain
Gains = dict[str, float]
Evaluate = Callable[[list[tuple[Gains, list[Flown]]]], list[list[Figures]]]
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Gain:
    """A gain that is free: its value at the start, its limits, and whether its logarithm is what is searched."""
    name: str
    start: float
    low: float
    high: float
    positive: bool

    def coded(self) -> float:
        """The start as the search has it."""
        return math.log(self.start) if self.positive else 1.0

    def decoded(self, x: float) -> float:
        """The gain at the search's `x`, to DIGITS digits and within its limits."""
        value = math.exp(min(x, 700.0)) if self.positive else x * self.start
        return min(max(float(f"{value:.{DIGITS}g}"), self.low), self.high)


def free_gains(file: FmuFile, names: list[str], preset: Mapping[str, Any]) -> list[Gain]:
    """The gains called `names`, starting from `preset`.

    Raises UsageError for one that the FMU does not have, that is no real parameter, or whose start is 0.
    """
    gains = []
    for name in names:
        v = file.variable(name)
        if v.causality != "parameter" or v.type != "Real":
            raise UsageError(f"--gain {name} cannot be tuned: it is no real parameter of {file.path.name}.")
        start = float(preset.get(name, v.start))
        if start == 0:
            raise UsageError(f"--gain {name} cannot be tuned from 0, which it is at the start: choose another preset.")
        low, high = (float(limit) if limit is not None else sign * math.inf
                     for limit, sign in ((v.min, -1), (v.max, 1)))
        gains.append(Gain(name, start, low, high, low >= 0))
    return gains


# --- flying, in processes of their own --------------------------------------------------------------------------------

BENCH: list[Bench] = []  # of this process


def begin(systems: Mapping[str, System]) -> None:
    """Prepare a worker process."""
    as_worker()
    BENCH[:] = [Bench(systems)]


def flown_by(gains: Gains, flights: list[Flown]) -> list[Figures]:
    """All `flights` with `gains`, in a worker process."""
    return [BENCH[0].fly(flight, gains) for flight in flights]


@contextmanager
def flying(systems: Mapping[str, System], workers: int) -> Iterator[Evaluate]:
    """A function that flies pairs of gains and flights in `workers` processes."""
    pool = ProcessPoolExecutor(workers, get_context("spawn"), begin, (systems,))
    try:
        yield lambda tasks: list(pool.map(flown_by, *zip(*tasks)))
    except BaseException:
        for worker in active_children():  # what they fly is of no use, and may not end by itself
            worker.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def flown_one_by_one(evaluate: Evaluate, gains: Gains, flights: list[Flown]) -> list[Figures]:
    """One set of gains on many flights, divided among the workers."""
    return [found for [found] in evaluate([(gains, [flight]) for flight in flights])]


# --- the search -------------------------------------------------------------------------------------------------------

def cost(fixed: list[Flown], found: list[Figures]) -> float:
    """What the search minimises: the mean over the drawn flights, which come first, and the fixed ones by weight."""
    drawn, others = found[:len(found) - len(fixed)], found[len(found) - len(fixed):]
    mean = float(np.mean([f.cost for f in drawn])) if drawn else 0.0
    return mean + sum(flown.weight * f.cost for flown, f in zip(fixed, others))


def shares(found: list[Figures]) -> dict[str, float]:
    """How drawn flights went: shares within WITHIN_FT and kept, median and 99 % of the altitude error (ft)."""
    h = np.array([f.h for f in found])
    kept = np.array([f.kept for f in found])
    return {"within_20_ft": float(np.mean(kept & (h < WITHIN_FT))), "kept": float(kept.mean()),
            "altitude_error_ft_median": float(np.median(h)), "altitude_error_ft_99": float(np.quantile(h, 0.99))}


def searched(free: list[Gain], training: list[Flown], test: list[Flown], fixed: list[Flown], evaluate: Evaluate,
             evaluations: int, seed: int, sigma: float) -> Iterator[dict[str, Any]]:
    """The state of the search after each generation: `gains` are the best by the test draws so far, which fly every
    CHECK_EVERY generations, `training_gains` the best by the training draws."""
    import cma

    def decoded(x: Any) -> Gains:
        return {gain.name: gain.decoded(float(value)) for gain, value in zip(free, x)}

    def tested(gains: Gains) -> tuple[float, Gains]:
        return cost(fixed, flown_one_by_one(evaluate, gains, [*test, *fixed])), gains

    first = {gain.name: gain.start for gain in free}
    at_start = cost(fixed, flown_one_by_one(evaluate, first, [*training, *fixed]))
    best, known = tested(first), [(at_start, first)]
    state = {"evaluations": 0, "generation": 0, "gains": first, "test_cost": best[0], "training_cost": at_start,
             "training_gains": first,
             "start": {"gains": first, "training_cost": at_start, "test_cost": best[0]}}
    yield state
    search = cma.CMAEvolutionStrategy([gain.coded() for gain in free], sigma, {
        "seed": seed, "verbose": -9, "verb_log": 0})
    done = False
    while not done:
        points = search.ask()
        candidates = [decoded(x) for x in points]
        costs = [cost(fixed, found) for found in evaluate([(gains, [*training, *fixed]) for gains in candidates])]
        search.tell(points, costs)
        known = [min([*known, *zip(costs, candidates)], key=lambda pair: pair[0])]
        generation = search.countiter
        done = bool(search.stop()) or search.countevals + search.popsize > evaluations
        if generation % CHECK_EVERY == 0 or done:
            found = [tested(gains) for gains in (known[0][1], decoded(search.result.xfavorite))]
            best = min([best, *found], key=lambda pair: pair[0])
        state = {**state, "evaluations": int(search.countevals), "generation": generation, "gains": best[1],
                 "test_cost": best[0], "training_cost": known[0][0], "training_gains": known[0][1]}
        yield state


def tune(law: str, preset: str | None = None, flights: str = "independent", gain: list[str] | None = None,
         evaluations: int = 960, draws: int = 48, seed: int = 1, sigma: float = 0.3, workers: int = 2,
         out: Path | None = None, tell: Tell = lambda line: None) -> dict[str, Any]:
    """Tune `law` (a word of the registry, or anybody's FMU as NAME=FILE.fmu), beginning with its `preset`.

    `flights` is one of `tune_flights.SETS`. `gain` names the gains that are free; without it they are the registry's,
    or, of an FMU file, those that the preset sets. `evaluations` is how many sets of gains are flown, each on `draws`
    drawn vehicles; twice as many are test draws, four times as many fresh ones. `sigma` is the search's first step, of
    a gain's logarithm. The same arguments give the same gains, with any number of `workers` (processes).

    Returns what tune.json has in `out`, else in results/tune/LAW; it is written anew after each generation. `tell` is
    told a line for each. Raises UsageError for what cannot be tuned, RunError after Ctrl-C: the best so far is kept.
    """
    for option, value, most in (("evaluations", evaluations, 10**9), ("draws", draws, 10**6), ("seed", seed, 2**32 - 1),
                                ("workers", workers, 1000)):
        if not 1 <= value <= most:
            raise UsageError(f"--{option} {value} is not allowed: it must be between 1 and {most}.")
    if not 0 < sigma <= LARGEST_SIGMA:
        raise UsageError(f"--sigma {sigma:g} is not allowed: it must be a positive number, at most {LARGEST_SIGMA:g}.")
    chosen = SETS[choice("flights", flights, SETS)]
    preset = preset or (LAWS[law].preset if law in LAWS else None)
    presets = {"controller": preset} if preset else {}
    needed = {flown.scenario for flown in (*chosen.fixed, *chosen.drawn)}
    loops = {scenario: closed_loop(scenarios.load(scenario), law, presets=presets) for scenario in sorted(needed)}
    systems, free = prepared({scenario: loop.system for scenario, loop in loops.items()}, law, gain)
    name = next(iter(loops.values())).controller
    seeds = {use: 10 * seed + k for k, use in enumerate(("training", "test", "fresh"))}
    counts = {"training": draws, "test": 2 * draws, "fresh": 4 * draws}
    drawn = {use: vehicles(chosen, counts[use], seeds[use]) for use in seeds}
    record: dict[str, Any] = {
        "kind": "tune", "law": name, "preset": preset, "flights": flights, "seed": seed, "sigma": sigma,
        "budget": evaluations, "draws": {use: {"seed": seeds[use], "count": len(drawn[use])} for use in seeds},
        "status": "running"}

    with claimed(out, "tune", name) as folder:
        def keep(**more: Any) -> None:
            record.update(more)
            with whole(folder / "tune.json") as partial:
                partial.write_text(json.dumps(record, indent=2) + "\n")

        try:
            with flying(systems, workers) as evaluate:
                for state in searched(free, drawn["training"], drawn["test"], list(chosen.fixed), evaluate, evaluations,
                                      seed, sigma):
                    keep(**state)
                    tell(f"{state['evaluations']} of {evaluations} evaluations, cost: training "
                         f"{state['training_cost']:.4f}, test {state['test_cost']:.4f}")
                if drawn["fresh"]:
                    keep(fresh={who: shares(flown_one_by_one(evaluate, gains, drawn["fresh"])) for who, gains in (
                        ("start", record["start"]["gains"]), ("tuned", record["gains"]))})
        except KeyboardInterrupt:
            keep(status="interrupted")
            raise RunError(f"Interrupted; the best gains so far are in {folder / 'tune.json'}.") from None
        keep(status="finished")
    return {**record, "out": str(folder)}


def prepared(systems: dict[str, System], law: str, gain: list[str] | None) -> tuple[dict[str, System], list[Gain]]:
    """The systems with quick internal steps, and the gains that are free. Raises UsageError, see `free_gains`."""
    quick = {}
    for scenario, system in systems.items():
        parts = []
        for component in system.components:
            with FmuFile.open(component.fmu) as file:
                inner = {"internal_step": QUICK} if "internal_step" in file.variables else {}
                if component.name == "controller":
                    names = gain or list(LAWS[law].gains if law in LAWS else component.values)
                    free = free_gains(file, names, component.values)
            parts.append(component.with_values(inner))
        quick[scenario] = replace(system, components=tuple(parts))
    if not free:
        raise UsageError(f"{law} has no gains to tune: name a preset of it, or gains with --gain.")
    return quick, free
