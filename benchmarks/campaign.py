"""A campaign of Case 1 with one worker and with two, the same flights in two processes that do nothing else, and the
plain way: `ahv bench campaign`.

The plain way is what one would write at first: a Python loop over fmpy, pythonfmu FMUs, a multiprocessing pool. It is
measured on fewer runs, with the same draws, loading the FMUs anew for each run. Options: --runs N (1000), --plain-runs
N (4), --json. CPU seconds are given too, since wall time says little on a machine that others use.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from pathlib import Path

import yaml

AHV = Path(sys.executable).parent / "ahv"
SAMPLE = 200  # runs
FILE = Path(__file__).parent.parent / "docs" / "campaigns" / "mild.yaml"


def children_cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def ours(file: Path, workers: int, folder: Path) -> dict[str, float]:
    """From command to report, in a process of its own."""
    began, before = time.perf_counter(), children_cpu()
    said = subprocess.run([AHV, "campaign", file, "--workers", str(workers), "--out", folder, "--json"], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    wall, summary = time.perf_counter() - began, json.loads(said)
    return {"workers": workers, "wall_s": wall, "cpu_s": children_cpu() - before, "flying_s": summary["flying_s"],
            "runs_per_s": summary["runs"] / summary["flying_s"]}


def wait_for(barrier: Barrier) -> None:
    """Keep what processes of a pool wait for, so that they begin together."""
    global together
    together = barrier


def flights(file: Path, first: int, last: int) -> float:
    """Seconds that the flights of these runs take in this process: systems are loaded, nothing is written."""
    from cosim.campaign.plan import load
    from cosim.campaign.worker import LoadedSystems, keep, requests
    from cosim.vehicle.campaigns import Laws

    plan = load(file, Laws)
    with tempfile.TemporaryDirectory() as folder:
        for stored, path in plan.fmus.items():
            keep(Path(folder), stored, path.read_bytes())
        systems, asked = LoadedSystems(plan.job, Path(folder)), list(requests(plan.job, first, last))
        systems.fly(asked[0])
        together.wait()
        began = time.perf_counter()
        for request in asked:
            systems.fly(request)
        took = time.perf_counter() - began
        systems.close()
    return took


def alone(file: Path, runs: int, sample: int) -> float:
    """Seconds that `runs` flights take in two processes that do nothing else, by a `sample` of them."""
    context = get_context("spawn")
    with context.Pool(2, wait_for, (context.Barrier(2),)) as pool:
        half = sample // 2
        took = pool.starmap(flights, [(file, 0, half), (file, half, sample)], chunksize=1)
    return max(took) * runs / sample


def plain_run(values: dict[str, dict[str, float]]) -> float:
    """One flight as a loop over fmpy; the largest altitude error."""
    import shutil

    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    from cosim.vehicle.closed_loop import CLOSED_LOOP, fmu_path

    slaves, references, folders = {}, {}, []
    for name, model in (("scenario", "AhvScenario"), ("controller", "AhvController"), ("plant", "AhvPlant")):
        path = str(fmu_path("python", model))
        description = read_model_description(path)
        folders.append(extract(path))
        references[name] = {v.name: v.valueReference for v in description.modelVariables}
        slaves[name] = slave = FMU2Slave(guid=description.guid, modelIdentifier=model, unzipDirectory=folders[-1],
                                         instanceName=name)
        slave.instantiate()
        given = values.get(name, {})
        slave.setReal([references[name][n] for n in given], list(given.values()))
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
    links = [(slaves[a], [references[a][n] for n in names], slaves[b], [references[b][n] for n in names])
             for a, b, names in CLOSED_LOOP]
    for _ in range(2):
        for source, outputs, target, inputs in links:
            target.setReal(inputs, source.getReal(outputs))
    for slave in slaves.values():
        slave.exitInitializationMode()
    worst = 0.0
    for tick in range(10_000):
        for slave in slaves.values():
            for source, outputs, target, inputs in links:
                if target is slave:
                    target.setReal(inputs, source.getReal(outputs))
            slave.doStep(currentCommunicationPoint=tick * 0.01, communicationStepSize=0.01)
        h, = slaves["plant"].getReal([references["plant"]["h"]])
        reference, = slaves["controller"].getReal([references["controller"]["h_reference"]])
        worst = max(worst, abs(h - reference))
    for slave in slaves.values():
        slave.terminate()
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)
    return worst


def plain(file: Path, runs: int) -> dict[str, float]:
    """The first runs of the campaign, in a pool of two processes."""
    from cosim.campaign.plan import load
    from cosim.campaign.worker import requests
    from cosim.vehicle.campaigns import Laws

    drawn = []
    for request in requests(load(file, Laws).job, 0, runs):
        values: dict[str, dict[str, float]] = {}
        for name, value in request.values.items():
            values.setdefault(name.partition(".")[0], {})[name.partition(".")[2]] = float(value)
        drawn.append(values)
    began, before = time.perf_counter(), children_cpu()
    with get_context("spawn").Pool(2) as pool:
        found = pool.map(plain_run, drawn, chunksize=1)
        pool.close()
        pool.join()
    wall = time.perf_counter() - began
    return {"runs": runs, "wall_s": wall, "cpu_s": children_cpu() - before, "runs_per_s": runs / wall,
            "worst_altitude_error_ft": max(found)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--plain-runs", type=int, default=4)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        file = folder / "campaign.yaml"
        file.write_text(yaml.dump({**yaml.safe_load(FILE.read_text()), "runs": options.runs}, sort_keys=False))
        before = alone(file, options.runs, SAMPLE)
        found = [ours(file, workers, folder / f"out{workers}") for workers in (2, 1)][::-1]
        flown = (before + alone(file, options.runs, SAMPLE)) / 2
        result = {"load_average": os.getloadavg()[0], "campaign": found, "flights_alone_s": flown,
                  "efficiency_while_flying": flown / found[1]["flying_s"],
                  "efficiency_from_command_to_report": flown / found[1]["wall_s"],
                  "efficiency_of_two": found[0]["flying_s"] / (2 * found[1]["flying_s"]),
                  "efficiency_of_two_by_cpu": found[0]["cpu_s"] / found[1]["cpu_s"]}
        if options.plain_runs:
            result["plain"] = plain(file, options.plain_runs)
            result["times_faster_than_plain"] = found[1]["runs_per_s"] / result["plain"]["runs_per_s"]
    if options.json:
        print(json.dumps({"campaign": result}))
        return
    for row in [*found, result.pop("plain", {})]:
        print("  ".join(f"{key} {value:g}" for key, value in row.items()))
    print("  ".join(f"{key} {value:g}" for key, value in result.items() if isinstance(value, float)))


if __name__ == "__main__":
    main()
