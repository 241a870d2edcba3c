"""Records the experiments that travel in the controllers' FMUs (FMI-LS-REF), into ahv_ctrl_fmu/experiments/.

    .venv/bin/python benchmarks/record_experiments.py [--out DIR]

The loop is flown; measurements and commands become the inputs of an experiment, rounded as a sensor would have them.
The controller alone is then stepped through these inputs, which gives the golden outputs.
"""
import argparse
import csv
import random
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import cosim
from cosim import Component, System
from cosim.master.flight import Flight
from cosim.master.fmu import preset
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop, fmu_path
from cosim.vehicle.registry import LAWS, Model
from cosim.vehicle.scenarios import GROUPS
from fmus.description import xml_bytes

ROOT = Path(__file__).parents[1]
FLIGHT_STEP = 0.01   # s, of the loop
TOLERANCE = 1e-6     # of a variable's nominal value
DIGITS = {"V": 3, "h": 2, "gamma": 7, "theta": 7, "Q": 6, "V_command": 3, "h_command": 2}  # after the decimal point
DRAWS, SEED, HALF_TURN = 4, 22, 3.14


@dataclass(frozen=True)
class Experiment:
    """What is flown, and how it is recorded: a row of inputs each `step` s, a row of outputs each `rows` steps."""
    name: str
    about: str
    scenario: str
    stop: float
    step: float
    rows: int
    set: tuple[tuple[str, float], ...] = ()


def uncertain(number: int, draw: random.Random) -> Experiment:
    """Case 1 with a vehicle whose coefficient groups swing by 40 %, each with a phase of its own."""
    phases = tuple((f"scenario.scale_{group}_sine_phase", round(draw.uniform(-HALF_TURN, HALF_TURN), 2))
                   for group in GROUPS)
    said = ", ".join(f"{group} {phase:g}" for group, (_, phase) in zip(GROUPS, phases))
    return Experiment(f"uncertain-{number}", f"a vehicle of Case 1 with phases (rad) {said}", "case1", 20.0, 0.1, 10,
                      phases)


FILES = {
    "smoke-test": ("The first second of Case 1.",
                   [Experiment("smoke", "the first second of Case 1", "case1", 1.0, 0.02, 10)]),
    "validation": ("Cases 1 and 2 of the paper, as the controller saw them.",
                   [Experiment("case1", "Case 1: steps of 200 ft/s and 800 ft, 40 % uncertainty", "case1", 100.0, 0.1,
                                20),
                    Experiment("case2", "Case 2: steps of velocity, a square wave of altitude, 40 % uncertainty",
                               "case2", 300.0, 0.2, 25)]),
    "uncertainty-analysis": (f"Case 1 with {DRAWS} vehicles, drawn at random: every coefficient group errs on its own.",
                             [uncertain(n, draw) for draw in [random.Random(SEED)] for n in range(1, DRAWS + 1)]),
}


def table(time: list[float], columns: dict[str, list[str]]) -> str:
    """A table as CSV."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *columns])
    writer.writerows(zip((f"{t:.10g}" for t in time), *columns.values()))
    return text.getvalue()


def inputs_of(law: Model, experiment: Experiment) -> tuple[list[float], dict[str, list[str]]]:
    """Times (s) and the controller's inputs of a flight of the loop, until its end or the vehicle's."""
    plan = scenarios.load(experiment.scenario).model_copy(update={"set": dict(experiment.set)})
    system = closed_loop(plan, law.word, flavour="native").system
    flight = cosim.fly(system, FLIGHT_STEP, experiment.stop, progress=False)
    every = round(experiment.step / FLIGHT_STEP)
    rows = range(0, flight.ticks + 1, every)
    columns = {target.partition(".")[2]: [flight[source][k] for k in rows] for source, target in
               ((link.source, link.target) for link in system.connections) if target.startswith("controller.")}
    return ([n * experiment.step for n in range(len(rows))],
            {name: [f"{value:.{DIGITS[name]}f}" for value in values] for name, values in columns.items()})


def outputs_of(law: Model, experiment: Experiment, inputs: Path, stop: float) -> Flight:
    """The flight of the controller alone through the inputs in a file, until `stop` (s)."""
    fmu = fmu_path("native", law.fmu)
    alone = System((Component("law", fmu, preset(fmu, str(law.preset))),))
    return cosim.fly(alone, experiment.step, stop, inputs=inputs, progress=False)


def record(law: Model, folder: Path) -> None:
    """Write the experiments of a law into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for kind, (about, experiments) in FILES.items():
        root = Element("Experiments", name=f"{law.fmu}, {kind}", description=about)
        for experiment in experiments:
            time, columns = inputs_of(law, experiment)
            last = (len(time) - 1) // experiment.rows * experiment.rows
            inputs = folder / f"{experiment.name}-in.csv"
            inputs.write_text(table(time[:last + 1], {n: values[:last + 1] for n, values in columns.items()}))
            flight = outputs_of(law, experiment, inputs, time[last])
            rows = range(0, last + 1, experiment.rows)
            shown = {name.partition(".")[2]: [f"{flight[name][k]:.12g}" for k in rows] for name in flight}
            (folder / f"{experiment.name}-ref.csv").write_text(table([time[k] for k in rows], shown))
            element = SubElement(root, "Experiment", name=experiment.name, description=experiment.about,
                                 tolerance=f"{TOLERANCE:g}")
            SubElement(element, "TransientSimulation", startTime="0", stopTime=f"{time[last]:.10g}",
                       stepSize=f"{experiment.step:g}")
            SubElement(element, "Parameters", source=f"../../resources/presets/{law.preset}.ssv")
            SubElement(element, "Stimuli", source=inputs.name)
            SubElement(element, "References", source=f"{experiment.name}-ref.csv")
        (folder / f"{kind}.exp").write_bytes(xml_bytes(root))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "ahv_ctrl_fmu" / "experiments")
    out = parser.parse_args().out
    for law in LAWS.values():
        record(law, out / law.fmu)


if __name__ == "__main__":
    main()
