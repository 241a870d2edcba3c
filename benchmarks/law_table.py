"""The table of docs/laws/resilient.md: how often `resilient` keeps the vehicle, and within what, flown and printed.

    .venv/bin/python benchmarks/law_table.py [NAME...] [--workers N]     (all of ROWS; an hour on two cores)

Each row is a campaign of docs/campaigns, or one with another seed, flown by `ahv campaign` into results/law_table/NAME;
a row that has been flown is only printed, an interrupted one is continued. Intervals are Clopper and Pearson's, 95 %.
"""
import argparse
import statistics
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import yaml

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

from evidence import DEPARTED, GROUPS, Loaded, fly, summary  # noqa: E402
from law_studies import STRUCTURES, apart, independent, modes  # noqa: E402
from native_step import native  # noqa: E402
from studies import NOISE  # noqa: E402

from cosim.campaign.campaign import campaign  # noqa: E402
from cosim.campaign.statistics import interval  # noqa: E402
from cosim.vehicle.campaigns import Laws  # noqa: E402

CAMPAIGNS = HERE.parent / "docs" / "campaigns"
OUT = Path("results") / "law_table"
# Name -> the campaign's file, and what is changed in it. 4711 and 4712 are the seeds that no tuning has seen.
ONLY = {"controllers": ["resilient"]}
ROWS = {
    "case1": ("case1", ONLY), "case1_fresh": ("case1", {**ONLY, "seed": 4711}),
    "case2": ("case2", ONLY), "case2_fresh": ("case2", {**ONLY, "seed": 4712}),
    "sensors": ("resilient_sensors", {}), "amplitudes": ("amplitudes", ONLY), "instruments": ("instruments", {}),
    "structures_case1": ("resilient_structures_case1", {}), "structures_case2": ("resilient_structures_case2", {}),
}
LAWS = {"neural": "AhvController", "backstepping": "AhvBackstepping", "resilient": "AhvResilient"}


def flown(name: str, workers: int | None) -> dict[str, pa.Table]:
    """The rows of a campaign for each of its controllers; flown if they have not been."""
    file, changes = ROWS[name]
    OUT.mkdir(parents=True, exist_ok=True)
    path = OUT / f"{name}.yaml"
    path.write_text(yaml.safe_dump({**yaml.safe_load((CAMPAIGNS / f"{file}.yaml").read_text()), **changes},
                                   sort_keys=False))
    campaign(path, OUT / name, resume=True, workers=workers, subjects=[Laws])
    table = pq.read_table(OUT / name / "runs.parquet")
    laws = table["controller"].unique().to_pylist()
    return {law: table.filter(pc.equal(table["controller"], law)) for law in laws}


def share(found: np.ndarray) -> str:
    """How many are true, in per cent with the interval."""
    low, high = interval(int(found.sum()), len(found))
    return f"{100 * found.mean():6.2f} ({100 * low:.2f}-{100 * high:.2f})"


def print_campaigns(names: list[str], workers: int | None) -> None:
    """One line for each controller of each campaign; errors are those of the flights that were kept."""
    print(f"{'campaign':36} {'runs':>5} {'success, %':>22} {'within 20 ft, %':>22} {'kept, %':>22}"
          "   h median, 99 %, max (ft)   V median, 99 % (ft/s)   protected median, max (s)   travel median, 99 % (deg)")
    for name in names:
        for law, rows in flown(name, workers).items():
            h = rows["altitude_error_ft.max_abs"].to_numpy()
            kept = pc.equal(rows["status"], "finished").to_numpy() & (h < DEPARTED)
            within = kept & (h < 20)
            V, held, travel = (rows[column].to_numpy()[kept] for column in (
                "velocity_error_fps.max_abs", "protected_s", "elevator_deg.travel"))
            print(f"{name if law == 'resilient' else f'{name}, {law}':36} {len(rows):5} "
                  f"{share(rows['success'].to_numpy()):>22} {share(within):>22} {share(kept):>22}   "
                  f"{np.median(h[kept]):6.2f} {np.quantile(h[kept], 0.99):6.2f} {h[kept].max():6.2f}      "
                  f"{np.median(V):6.2f} {np.quantile(V, 0.99):6.1f}           {np.median(held):6.2f} {held.max():6.2f}"
                  f"            {np.median(travel):6.0f} {np.quantile(travel, 0.99):6.0f}", flush=True)


def print_flights() -> None:
    """What one flight shows."""
    print()
    for form in ("quiet", "lean", "coupled"):
        for case in ("case1", "case2"):
            for step in (0.01, 0.05):
                one = summary(fly(case, "resilient", form, step=step))
                print(f"{form}, {case}, all groups together, {1000 * step:.0f} ms: h {one.h:.2f} ft, "
                      f"V {one.V:.2f} ft/s, travel {one.travel:.0f} deg")
    loss = {"scenario": {f"scale_{group}_{key}": value for group in GROUPS
                         for key, value in (("base", 0.9), ("sine", 0.0))}}
    for form in ("quiet", "lean", "coupled"):
        lost = summary(fly("case1", "resilient", form, loss))
        print(f"{form}, case1, a tenth of all coefficients lost at the start: "
              f"h {lost.h:.2f} ft")
        for part in (0.1, 1.0):
            one = summary(fly("case1", "resilient", form, {"plant": {n: part * v for n, v in NOISE.items()}},
                              "instrumented"))
            print(f"{form}, case1, {part:g} units of noise: h {one.h:.2f} ft, travel {one.travel:.0f} deg in 100 s")


def print_structures(count: int = 100) -> None:
    """Preset `coupled` on structures that are not what they are thought to be: independent groups, 40 s of Case 1."""
    print()
    errors = {"as it is": {}, "modes x 0.9": modes(0.9), "modes x 1.1": modes(1.1),
              "N1 x 1.4, N2 x 0.6": apart(1.4, 0.6), "N1 x 0.6, N2 x 1.4": apart(0.6, 1.4)}
    with Loaded("resilient", "coupled") as loaded:
        for name, structure in STRUCTURES.items():
            for error, changed in errors.items() if structure else [("as it is", {})]:
                found = [summary(loaded.fly("case1", {**values, "plant": {**structure, **changed}}, stop=40))
                         for values in independent(24, count)]
                kept = [flight for flight in found if flight.survived]
                print(f"coupled, {name}, {error}: within {sum(flight.h < 20 for flight in kept)}, kept {len(kept)} of "
                      f"{count}; travel median {np.median([flight.travel for flight in kept]):.0f}, "
                      f"largest {max(flight.travel for flight in kept):.0f} deg", flush=True)


def print_cost(rounds: int = 5) -> None:
    """Time of a 10 ms step as native FMU, the laws by turns."""
    found: dict[str, list[float]] = {law: [] for law in LAWS}
    for _ in range(rounds):
        for law, fmu in LAWS.items():
            found[law].append(native(fmu))
    best = {law: min(times) for law, times in found.items()}
    print("\ntime of a 10 ms step, best and median of", rounds, "rounds (us): "
          + ", ".join(f"{law} {best[law]:.3f}, {statistics.median(times):.3f}" for law, times in found.items())
          + f"; resilient / neural {best['resilient'] / best['neural']:.2f}")


OTHERS = {"flights": print_flights, "structures": print_structures, "cost": print_cost}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rows", nargs="*", metavar="NAME", help=f"of {', '.join([*ROWS, *OTHERS])}; none: all")
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    wanted = given.rows or [*ROWS, *OTHERS]
    if unknown := set(wanted) - {*ROWS, *OTHERS}:
        parser.error(f"there is no {unknown.pop()}; there are {', '.join([*ROWS, *OTHERS])}")
    if campaigns := [name for name in ROWS if name in wanted]:
        print_campaigns(campaigns, given.workers)
    for name, show in OTHERS.items():
        if name in wanted:
            show()
