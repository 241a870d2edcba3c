"""Error of each algorithm against the step, as a log-log picture: `ahv bench orders [--json]`.

Two systems: two oscillators (the small FMU; exact solution by the matrix exponential), and the vehicle under control
(Case 1, native FMUs, DOP853 to 1e-12 on the continuous equations). The error is the largest one of the signals, each
over its nominal (or largest) value, at the times that all steps share. The variable algorithm is shown over its mean
step, and beside the fixed step of equal error.
"""
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from scipy.linalg import expm

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]

import oracle  # noqa: E402
import small  # noqa: E402

from cosim import pictures  # noqa: E402
from cosim.master.fly import fly  # noqa: E402
from cosim.vehicle import scenarios  # noqa: E402
from cosim.vehicle.closed_loop import assignments, closed_loop  # noqa: E402

STEPS = (0.001, 0.002, 0.004, 0.008, 0.016)
TOLERANCES = (1e-4, 1e-6, 1e-8)
ALGORITHMS = ("jacobi", "gauss-seidel", "multi-rate,{slow}=4", "iterated", "jacobi,hold=linear",
              "gauss-seidel,hold=linear", "iterated,hold=linear")
OUT = Path("results") / "bench"


class Pair:
    """Two oscillators; the direct variant does not say what depends on what, so that `iterated` iterates."""
    title, slow, stop = "two oscillators", "right", 3.84
    names = ("left.y", "left.y2", "right.y", "right.y2")

    def __init__(self, folder, **variant):
        self.system = small.pair(small.build(folder, **variant))
        self.scale = np.ones(4)

    def truth(self, times):
        whole = np.array([[0, 1, 0, 0], [-4, -0.3, 0.8, 0], [0, 0, 0, 1], [1, 0, -9, -0.3]])
        return np.array([expm(whole * t) @ [1.0, 0.0, -0.5, 0.2] for t in times])


class Vehicle:
    """Case 1 under the neural law: nine states of the plant."""
    title, slow, stop = "the vehicle, Case 1", "controller", 9.6
    names = tuple(f"plant.{n}" for n in ("V", "h", "gamma", "theta", "Q", "eta1", "eta1_dot", "eta2", "eta2_dot"))

    def __init__(self, fine):
        plan = scenarios.load("case1")
        # The FMUs' own steps as short as needed not to be seen.
        words = [f"plant.internal_step={fine}", f"controller.internal_step={fine}"]
        self.system = closed_loop(plan, values=assignments(words)).system
        self.scale = np.array([1000, 1000, .01, .01, .01, 1, 20, 1, 20])

    def truth(self, times):
        return oracle.ClosedLoop("case1").solve(np.asarray(times))[:, :9]


def errors(system, algorithm, step, truth_at, truth):
    """(largest scaled error, ticks) of one flight."""
    flight = fly(system.system, step, system.stop, algorithm.format(slow=system.slow), record=list(system.names))
    if not flight.finished:
        return float("nan"), flight.ticks
    index = np.clip(np.searchsorted(flight.time, truth_at - 1e-9), 0, len(flight.time) - 1)
    assert np.allclose(flight.time[index], truth_at, atol=1e-8)
    shown = np.column_stack([flight[n][index] for n in system.names])
    return float(np.abs((shown - truth) / system.scale).max()), flight.ticks


def measure(system) -> dict:
    """algorithm -> errors at STEPS and slope; `variable` -> tolerance -> error, ticks, ticks of equal error."""
    common = np.arange(0, system.stop + 1e-9, 4 * max(STEPS))
    truth, found = system.truth(common), {}
    for word in ALGORITHMS:
        reached = [errors(system, word, step, common, truth)[0] for step in STEPS]
        slope = float(np.polyfit(np.log(STEPS[:4]), np.log(reached[:4]), 1)[0])
        found[word.format(slow=system.slow)] = {"errors": reached, "slope": slope}
        print(system.title, word, found[word.format(slow=system.slow)], file=sys.stderr)
    return found


def measure_variable(system) -> dict:
    """tolerance -> error at the end, ticks, and how many fixed steps of hold=linear the same error takes."""
    end = np.array([0.0, system.stop])
    truth, found = system.truth(end), {}
    fixed = [errors(system, "gauss-seidel,hold=linear", step, end, truth)[0] for step in STEPS]
    slope, height = np.polyfit(np.log(STEPS), np.log(fixed), 1)
    for tolerance in TOLERANCES:
        error, ticks = errors(system, f"variable,tolerance={tolerance}", 0.01, end, truth)
        equal = np.exp((np.log(error) - height) / slope)
        found[f"{tolerance:g}"] = {"error": error, "ticks": ticks, "fixed_ticks_of_equal_error": system.stop / equal}
        print(system.title, tolerance, found[f"{tolerance:g}"], file=sys.stderr)
    return found


def draw(results: dict, path: Path) -> None:
    """Errors over the step, and below over Jacobi's; hollow marks for inputs that follow their last slope."""
    ms = 1e3 * np.array(STEPS)
    with pictures.style():
        figure = Figure(figsize=(pictures.WIDTHS[2], 5.6), layout="constrained")
        axes = figure.subplots(2, len(results), sharex=True, height_ratios=(3, 2))
        for (above, below), (title, found) in zip(axes.T, results.items()):
            count, jacobi = len(found["fixed"]), np.array(found["fixed"]["jacobi"]["errors"])
            # Where curves coincide, the larger marks are seen around the smaller.
            looks = zip(pictures.styled(count), pictures.MARKS, np.linspace(8, 3.5, count))
            for (word, row), (line, mark, size) in zip(found["fixed"].items(), looks):
                look = {"marker": mark, "markersize": size, "fillstyle": "none" if "linear" in word else "full", **line}
                above.plot(ms, row["errors"], label=f"{word}: {row['slope']:.2f}", **look)
                below.plot(ms, row["errors"] / jacobi, **look)
            for order in (1, 2):
                guide = jacobi[-1] / 3 ** order * (ms / ms[-1]) ** order
                above.plot(ms, guide, "-", color="0.6", linewidth=0.8)
                above.annotate(f"{order}", (ms[0], guide[0]), (-3, 0), textcoords="offset points", ha="right",
                               va="center", color="0.35", fontsize=7)
            above.set(title=title, xscale="log", yscale="log")
            below.set(xlabel="communication step (ms)", yscale="log")
            below.set_xticks(ms, [f"{step:g}" for step in ms])
            below.set_xlim(0.75 * ms[0], 1.2 * ms[-1])  # room for the numbers of the grey lines
            below.xaxis.set_minor_locator(NullLocator())
            below.legend(*above.get_legend_handles_labels(), title="slope (grey lines: 1 and 2)", loc="upper center",
                         bbox_to_anchor=(0.5, -0.3))
        axes[0, 0].set_ylabel("largest scaled error (1)")
        axes[1, 0].set_ylabel("error over that of jacobi (1)")
        pictures.save(figure, path)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        systems = [Pair(Path(folder), direct=None), Vehicle(2e-4)]
        results = {s.title: {"fixed": measure(s)} for s in systems}
        for system, result in zip((Pair(Path(folder)), systems[1]), results.values()):
            result["variable"] = measure_variable(system)
    OUT.mkdir(parents=True, exist_ok=True)
    draw(results, OUT / "orders.png")
    if "--json" in sys.argv:
        print(json.dumps({"steps_s": STEPS, "orders": results, "figure": str(OUT / "orders.png")}))
        return
    for title, result in results.items():
        print(f"\n{title}: error at steps of {', '.join(f'{1e3 * s:g}' for s in STEPS)} ms, slope")
        for word, row in result["fixed"].items():
            print(f"  {word:28}", *(f"{e:9.2e}" for e in row["errors"]), f"{row['slope']:6.2f}")
        for tolerance, row in result["variable"].items():
            print(f"  variable, tolerance {tolerance}: error {row['error']:.2e} in {row['ticks']} ticks; "
                  f"fixed steps of equal error: {row['fixed_ticks_of_equal_error']:.0f}")
    print(f"Figure: {OUT / 'orders.png'}")


if __name__ == "__main__":
    main()
