"""Our environment beside fmugym's: what a step and a reset cost, in one run.

    make peers                                            the environment that has fmugym
    .venv/bin/python benchmarks/environments.py [--rounds N]

Both fly the same FMU with the same inputs, one communication step of 10 ms an action, and show all of its outputs;
rewards are constant. Each measurement is a process of its own, in rounds in which they take turns, and counts processor
time. fmugym unpacks and loads the FMU anew at each reset, as its authors say because of an exporter's leaks.
"""
import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parent.parent
FMUGYM = ROOT / ".venv-peers" / "python" / "bin" / "python"
FMUS = {"the vehicle": "AhvPlant", "the controller": "AhvController"}
STEP, STEPS, RESETS = 0.01, 400, 40   # s; in an episode, before the vehicle falls; episodes


def ours(fmu: Path, values: dict[str, float], outputs: list[str]) -> tuple[Callable, Callable, Callable]:
    """reset, step and close of our environment."""
    import numpy as np

    import cosim

    name = fmu.stem
    environment = cosim.Environment(fmu, [f"{name}.{n}" for n in values], {f"{name}.{n}": (-1e9, 1e9) for n in outputs},
                                    lambda now: 0.0, scaled=False, step=STEP, stop=STEP * STEPS)
    action = np.array([*values.values()])
    return environment.reset, lambda: environment.step(action), environment.close


def fmugym(fmu: Path, values: dict[str, float], outputs: list[str]) -> tuple[Callable, Callable, Callable]:
    """The same of fmugym's."""
    import fmugym as package
    import numpy as np

    spaces = {word: package.VarSpace(word) for word in ("inputs", "outputs", "random")}
    for word, names in (("inputs", values), ("outputs", outputs)):
        for name in names:
            spaces[word].add_var_box(name, -1e9, 1e9)

    class Environment(package.FMUGym):
        init_states: dict = {}  # noqa: RUF012  (the base class sets into it)

        def compute_reward(self, *_):
            return 0.0

    environment = Environment(package.FMUGymConfig(str(fmu), 0.0, 2 * STEP * STEPS, STEP, STEP, inputs=spaces["inputs"],
                                                   outputs=spaces["outputs"], random_vars=spaces["random"]))
    action = np.array([values[name] for name in environment.input_dict])
    return environment.reset, lambda: environment.step(action), environment.close


def measure(name: str, fmu: Path, values: dict[str, float], outputs: list[str]) -> dict[str, float]:
    """Processor time of a step and of a reset, s, in this process."""
    reset, step, close = {"ours": ours, "fmugym": fmugym}[name](fmu, values, outputs)
    steps, resets = [], []
    for _ in range(RESETS):
        begun = time.process_time()
        reset()
        resets.append(time.process_time() - begun)
        begun = time.process_time()
        for _ in range(STEPS):
            step()
        steps.append((time.process_time() - begun) / STEPS)
    close()
    return {"step": median(steps), "reset": median(resets)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--one", nargs=4, help=argparse.SUPPRESS)
    words = parser.parse_args()
    if words.one:
        name, fmu, values, outputs = words.one
        print(json.dumps(measure(name, Path(fmu), json.loads(values), json.loads(outputs))))
        return
    from cosim.master.fmu import FmuFile
    from fmus.places import found

    print("| flown alone | signals | | step, µs | reset, ms |\n|---|---|---|---|---|")
    for what, model in FMUS.items():
        fmu = found("native", model)
        with FmuFile.open(fmu) as file:
            values = {n: float(file.start(n)) for n in file.names("input")}
            outputs = file.names("output")
        costs: dict[str, list[dict[str, float]]] = {"ours": [], "fmugym": []}
        for _ in range(words.rounds):
            for name, python in (("ours", sys.executable), ("fmugym", str(FMUGYM))):
                done = subprocess.run([python, __file__, "--one", name, str(fmu), json.dumps(values),
                                       json.dumps(outputs)], capture_output=True, text=True, check=True)
                costs[name].append(json.loads(done.stdout.splitlines()[-1]))
        for name, found_ in costs.items():
            step, reset = (median(cost[key] for cost in found_) for key in ("step", "reset"))
            print(f"| {what} | {len(values)} in, {len(outputs)} out | {name} | {1e6 * step:.1f} | {1e3 * reset:.2f} |")


if __name__ == "__main__":
    main()
