"""The search that found the gains of `resilient`, preset `quiet`: hard draws of all kinds, one cost, CMA-ES.

    .venv/bin/python benchmarks/tune_quiet.py [--evaluations 300] [--seed 1]     (about 2 s a set of gains, one core)

It begins with the preset and prints the best gains so far as JSON after each generation. What is flown, from draws of
its own: Case 1's hardest and random ones; servos and sensors as in docs/campaigns/instruments.yaml; an elevator of
30 rad/s and 60 deg/s; Q 30 ms late; Case 2's first jump; all groups together; a tenth and the full unit of noise.
"""
import argparse
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from evidence import Loaded, summary
from law_studies import LAG, independent
from studies import NOISE

from ahv_ctrl_fmu.resilient_model import QUIET
from cosim.campaign import plan as plans
from cosim.campaign.sampling import draw
from cosim.vehicle.campaigns import Laws
from cosim.yaml_file import Source

GAINS = [name for name, value in QUIET.items() if value and not isinstance(value, bool)]
LATE = {"Q_delay": 0.03}
LOST = 12.0           # cost of a lost vehicle; one within 18 ft costs at most 0.27
MOST_TRAVEL = 1500.0  # deg in 100 s
Flown = tuple[str, float, dict, dict]  # scenario, stop (s), values of the scenario, of the instrumented plant


def instruments(seed, count):
    """Plant values of the first runs of docs/campaigns/instruments.yaml, had it this seed."""
    source = Source(Path(__file__).parents[1] / "docs" / "campaigns" / "instruments.yaml", "campaign file")
    campaign, _ = plans.read(source, Laws)
    made = plans.make(campaign.model_copy(update={"seed": seed}), source, Laws)
    return [{name.partition(".")[2]: value for name, value in
             draw(made.draws["resilient"], made.job.sampler.uniforms(run)).items()} for run in range(count)]


class Search:
    """The flights, and what a set of gains costs on them."""

    def __init__(self):
        self.loops = {kind: Loaded("resilient", "quiet", kind) for kind in ("ideal", "instrumented")}

        def drawn(seed, count, case="case1", stop=40.0, plant=None):
            return [(case, stop, values["scenario"], plant or {}) for values in independent(seed, count)]

        case_1 = drawn(9001, 1200)
        self.hard = self.hardest(case_1, 36)
        self.random = case_1[-16:]
        self.servos = self.hardest([("case1", 100.0, {}, plant) for plant in instruments(9002, 500)], 30)
        self.others = [*self.hardest(drawn(9003, 400, "case2", 62.0), 12),
                       *self.hardest(drawn(9004, 500, plant=LAG), 14), *self.hardest(drawn(9004, 500, plant=LATE), 10)]

    def fly(self, flown: Flown, gains):
        case, stop, scenario, plant = flown
        return summary(self.loops["instrumented" if plant else "ideal"].fly(
            case, {"scenario": scenario, "plant": plant, "controller": gains}, stop=stop))

    def hardest(self, flights, count):
        """The flights that cost the preset most."""
        return sorted(flights, key=lambda flown: -penalty(self.fly(flown, {})))[:count]

    def cost(self, gains):
        """The sum of all penalties, and what is asked of flights together and in noise."""
        hard = [self.fly(flown, gains) for flown in self.hard]
        total = sum(map(penalty, hard)) + 0.02 * np.mean([min(flight.V, 300) for flight in hard])
        total += sum(min(self.fly(flown, gains).h, 100) / 5 for flown in self.random)
        total += sum(penalty(self.fly(flown, gains)) for flown in (*self.servos, *self.others))
        together = [self.fly((case, stop, {}, {}), gains).h for case, stop in (("case1", 60.0), ("case2", 160.0))]
        total += sum(2 * h / most + 40 * max(0, h - 1.02 * most) for h, most in zip(together, (3, 5)))
        for part, stop, most in ((0.1, 50.0, 140), (1.0, 25.0, 1080)):
            noise = {name: part * value for name, value in NOISE.items()}
            travel = self.fly(("case1", stop, {}, noise), gains).travel * 100 / stop
            total += travel / most + 100 * max(0, travel / most - 1)
        return float(total)


def penalty(flight):
    """What a flight costs: little below 18 ft, then 1 for each foot; travel above MOST_TRAVEL 4 for each 500 deg."""
    if not flight.survived:
        return LOST
    return 0.015 * flight.h + max(0.0, flight.h - 18) + 4 * max(0.0, (flight.travel - MOST_TRAVEL) / 500)


def main():
    """The command line."""
    import cma

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--evaluations", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    search = Search()
    found = cma.CMAEvolutionStrategy(np.zeros(len(GAINS)), 0.08, {
        "seed": given.seed, "verbose": -9, "verb_log": 0, "maxfevals": given.evaluations, "popsize": 12})

    def gains(x):
        return {name: float(f"{QUIET[name] * np.exp(value):.4g}") for name, value in zip(GAINS, x)}

    print(json.dumps({"evaluations": 0, "cost": search.cost({})}), flush=True)
    while not found.stop():
        points = found.ask()
        found.tell(points, [search.cost(gains(x)) for x in points])
        print(json.dumps({"evaluations": int(found.countevals), "cost": found.best.f, "gains": gains(found.best.x)}),
              flush=True)


if __name__ == "__main__":
    main()
