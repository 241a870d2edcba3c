"""Time per tick of our master and of others on the same SSP: `ahv bench masters [--json] [--out DIR]`.

The figures go to masters.json in DIR (results/bench), and masters.png draws what is in that file. What stands in docs/
is made by `ahv bench masters --out docs/pictures`; with `--from docs/pictures/masters.json` it is only drawn.

Each measurement is a process of its own, and rounds take turns, so that a busy machine is busy for all. Every master
is driven the fastest way it has: many ticks a call where there is one. Ours records all connected outputs, the others
nothing (fmpy.ssp records always). Start-up is left out: for fmpy.ssp by the difference of two lengths.
"""
import argparse
import json
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from statistics import median

ROUNDS = 5
OUT = Path("results") / "bench"


def ours(ssp: Path, step: float, ticks: int) -> dict[str, float]:
    """Jacobi, all connected outputs recorded; also the share of a tick that is not our own."""
    import ctypes

    import numpy as np

    from cosim.master import program as P
    from cosim.master.algorithms import method
    from cosim.master.algorithms.base import Experiment
    from cosim.master.fly import fly
    from cosim.master.loaded import Master, open_files
    from cosim.master.recording import CHUNK_ROWS, Recorder
    from cosim.ssp.load import load_ssp
    from fmus.native_compiler import cc

    with load_ssp(ssp) as found:
        system = found
        names = sorted({c.source for c in system.connections})
        fly(system, step, 10 * step, "jacobi", record=names)
        flight = fly(system, step, ticks * step, "jacobi", record=names)
        assert flight.finished, flight.message

        empty_library = ssp.with_name("nothing.so")
        empty_library.with_suffix(".c").write_text("int nothing(void) { return 0; }")
        cc("-O2", "-shared", "-fPIC", empty_library.with_suffix(".c"), "-o", empty_library)
        nothing = ctypes.cast(ctypes.CDLL(str(empty_library)).nothing, ctypes.c_void_p).value
        with open_files(system) as files:
            master = Master(system, files, names)
            chosen, recorder = method("jacobi"), Recorder(master.columns)
            flier = chosen.algorithm(master, chosen.options, Experiment(0.0, step, ticks, recorder))
            master.initialise(0.0, ticks * step)
            rows, times = recorder.room(CHUNK_ROWS)

            def chunk() -> float:
                found = []
                for _ in range(20):
                    master.cursor[:] = 0
                    begun = time.perf_counter()
                    assert master.attempt(flier.ops, 0, CHUNK_ROWS, 0.0, step, rows, times, 1) == 0
                    found.append(time.perf_counter() - begun)
                return float(np.median(found))

            real = chunk()
            master.wiring.groups[:, P.CALL], master.wiring.components[:, P.DO_STEP] = nothing, nothing
            empty = chunk()
            master.close()
    return {"us": 1e6 * flight.wall_s / ticks, "share_in_fmus": 1 - empty / real}


def libcosimpy(ssp: Path, step: float, ticks: int) -> dict[str, float]:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(str(ssp))
    execution.step(10)
    begun = time.perf_counter()
    if not execution.step(ticks):
        raise RuntimeError(str(execution.status()))
    return {"us": 1e6 * (time.perf_counter() - begun) / ticks}


def ecospy(ssp: Path, step: float, ticks: int) -> dict[str, float]:
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=str(ssp), step_size=step) as simulation:
        simulation.init(0, ssp.stem)  # the name of all parameter sets
        simulation.step(10)
        begun = time.perf_counter()
        simulation.step(ticks)
        return {"us": 1e6 * (time.perf_counter() - begun) / ticks}


def fmpy(ssp: Path, step: float, ticks: int) -> dict[str, float]:
    from fmpy.ssp.simulation import simulate_ssp

    took = []
    for count in (ticks, 2 * ticks):
        begun = time.perf_counter()
        simulate_ssp(str(ssp), stop_time=(count - 0.5) * step, step_size=step)
        took.append(time.perf_counter() - begun)
    return {"us": 1e6 * (took[1] - took[0]) / ticks}


# name -> function, the module it needs, ticks for two small FMUs, ticks for the vehicle
MASTERS = {
    "ours": (ours, "cosim", 1_000_000, 30_000),
    "ecospy": (ecospy, "ecospy", 200_000, 20_000),
    "libcosimpy": (libcosimpy, "libcosimpy", 5_000, 3_000),
    "fmpy.ssp": (fmpy, "fmpy", 5_000, 1_000),
}
UNMEASURED = {"OMSimulator": "OMSimulator", "PyFMI": "pyfmi"}


def write_systems(folder: Path) -> dict[str, Path]:
    """The two systems as SSP files."""
    sys.path.insert(0, str(Path(__file__).parent))
    import small

    from cosim.ssp.write import write
    from cosim.vehicle import scenarios
    from cosim.vehicle.closed_loop import closed_loop

    pair = small.pair(small.build(folder, others=False), a22=0.0)
    plan = scenarios.load("case2")
    vehicle = closed_loop(plan).system
    files = {"two small C FMUs": folder / "small.ssp", "the vehicle (3 native FMUs)": folder / "vehicle.ssp"}
    write(files["two small C FMUs"], "small", pair, 0.001, 1.0)
    write(files["the vehicle (3 native FMUs)"], "vehicle", vehicle, 0.01, 300.0)
    return files


def measure(master: str, ssp: Path, step: float, ticks: int) -> dict[str, float] | str:
    """One measurement in a process of its own; its figures, or why there are none."""
    import peers

    done = subprocess.run([sys.executable, __file__, "--one", master, str(ssp), str(step), str(ticks)],
                          capture_output=True, text=True, timeout=300, env=peers.environment())
    lines = done.stdout.strip().splitlines()
    if done.returncode or not lines:
        return (done.stderr.strip().splitlines() or [f"ended with {done.returncode}"])[-1]
    figures: dict[str, float] = json.loads(lines[-1])
    return figures


def compare(rounds: int) -> dict[str, dict]:
    """System -> master -> median, least and most microseconds per tick, ratio to ours; or why not."""
    result: dict[str, dict] = {}
    with tempfile.TemporaryDirectory() as folder:
        for (system, ssp), step, column in zip(write_systems(Path(folder)).items(), (0.001, 0.01), (2, 3)):
            known = {name: entry for name, entry in MASTERS.items() if find_spec(entry[1])}
            found: dict[str, list] = {name: [] for name in known}
            for _ in range(rounds):
                for name, entry in known.items():
                    found[name].append(measure(name, ssp, step, entry[column]))
                    print(f"{system}: {name}: {found[name][-1]}", file=sys.stderr)
            result[system] = {name: summary(figures) for name, figures in found.items()}
            own = result[system]["ours"].get("us")
            for row in result[system].values():
                if own and "us" in row:
                    row["ratio"] = row["us"] / own
    return result


def summary(figures: list) -> dict:
    good = [f for f in figures if not isinstance(f, str)]
    if not good:
        return {"message": figures[-1]}
    times = [f["us"] for f in good]
    row = {"us": median(times), "least_us": min(times), "most_us": max(times)}
    if "share_in_fmus" in good[0]:
        row["share_in_fmus"] = median(f["share_in_fmus"] for f in good)
    return row


def draw(result: dict[str, dict], path: Path) -> None:
    """Dots for the medians, with the least and the most: a bar has no foot on a logarithmic axis. A master without a
    figure is named all the same."""
    from matplotlib.figure import Figure

    from cosim import pictures

    with pictures.style():
        figure = Figure(figsize=(pictures.WIDTHS[2], 1.35 * len(result) + 0.4), layout="constrained")
        axes = figure.subplots(len(result), 1, sharex=True)
        for axis, (system, rows) in zip(axes, result.items()):
            for place, row in enumerate(rows.values()):
                if "us" not in row:
                    axis.text(0.01, place, "gave no result", transform=axis.get_yaxis_transform(),
                              va="center", fontsize=7)
                    continue
                spread = [[row["us"] - row["least_us"]], [row["most_us"] - row["us"]]]
                axis.errorbar(row["us"], place, xerr=spread, fmt="o", color=pictures.BLUE, markersize=5, capsize=3)
                axis.annotate(f"{row['us']:.3g} µs", (row["us"], place), (0, 6), textcoords="offset points",
                              ha="center", fontsize=7)
            axis.set(xscale="log", title=system, ylim=(len(rows) - 0.5, -0.7))
            axis.set_yticks(range(len(rows)), list(rows))
            axis.xaxis.set_major_formatter(pictures.number)
        axes[-1].set_xlabel("time per communication step (µs), median and spread of the rounds")
        pictures.save(figure, path)


def show(result: dict[str, dict]) -> None:
    from rich.console import Console
    from rich.table import Table

    for system, rows in result.items():
        table = Table("master", "µs per tick", "least", "most", "times ours", "share in FMUs", title=system)
        for name, row in rows.items():
            if "ratio" in row:
                share = f"{row['share_in_fmus']:.1%}" if "share_in_fmus" in row else ""
                table.add_row(name, *(f"{row[k]:.3g}" for k in ("us", "least_us", "most_us", "ratio")), share)
            else:
                table.add_row(name, row.get("message", ""))
        for name, module in UNMEASURED.items():
            table.add_row(name, "not measured" if find_spec(module) else "not installed")
        Console().print(table)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--one", nargs=4, metavar=("MASTER", "SSP", "STEP", "TICKS"))
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--out", type=Path, default=OUT, metavar="DIR")
    parser.add_argument("--from", type=Path, dest="measured", metavar="FILE", help="draw this masters.json again")
    parser.add_argument("--json", action="store_true")
    words = parser.parse_args()
    if words.one:
        name, ssp, step, ticks = words.one
        print(json.dumps(MASTERS[name][0](Path(ssp), float(step), int(ticks))), flush=True)
        return
    words.out.mkdir(parents=True, exist_ok=True)
    measured, figure = words.measured or words.out / "masters.json", words.out / "masters.png"
    if words.measured is None:
        measured.write_text(json.dumps(compare(words.rounds), indent=1) + "\n")
    result = json.loads(measured.read_text())
    draw(result, figure)
    if words.json:
        print(json.dumps({"masters": result, "figure": str(figure)}))
    else:
        show(result)
        print(f"Figure: {figure}")


if __name__ == "__main__":
    main()
