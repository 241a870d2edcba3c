"""Records the experiments that travel in our FMUs (FMI-LS-REF), into folders experiments/ beside the models.

    .venv/bin/python benchmarks/record_experiments.py [--out DIR]

The loop is flown; what a component is given becomes the inputs of its experiment, rounded as a sensor would have them.
The component alone is then stepped through these inputs, which gives the golden outputs.
"""
import argparse
import csv
import random
from dataclasses import dataclass
from importlib import import_module
from io import StringIO
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import cosim
from cosim import Component, System
from cosim.master.flight import Flight
from cosim.master.fmu import preset
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop, fmu_path
from cosim.vehicle.registry import LAWS, PLANTS, SCENARIO, Model
from cosim.vehicle.scenarios import GROUPS
from fmus.description import xml_bytes

FLIGHT_STEP = 0.01   # s, of the loop
TOLERANCE = 1e-6     # of a variable's nominal value
DIGITS = {"V": 3, "h": 2, "gamma": 7, "theta": 7, "Q": 6, "V_command": 3, "h_command": 2,  # after the decimal point
          "fuel_ratio": 6, "elevator": 7}
OTHER_DIGITS = 6
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


Files = dict[str, tuple[str, list[Experiment]]]  # experiment file -> what it is, its experiments
SMOKE: Files = {"smoke-test": ("The first second of Case 1.",
                               [Experiment("smoke", "the first second of Case 1", "case1", 1.0, 0.02, 10)])}
OF_SCENARIO: Files = {**SMOKE, "validation": (
    "The signals of Cases 1 and 2 of the paper.",
    [Experiment(case, f"{case}: commands and coefficient scales", case, stop, 0.5, 2)
     for case, stop in (("case1", 100.0), ("case2", 300.0))])}
OF_LAWS: Files = {
    **SMOKE,
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


def inputs_of(model: Model, place: str, experiment: Experiment) -> tuple[list[float], dict[str, list[str]]]:
    """Times (s) and inputs of the model at its place in the loop, in a flight until its end or the vehicle's."""
    plan = scenarios.load(experiment.scenario).model_copy(update={"set": dict(experiment.set)})
    choice = {place: model.word} if place in ("controller", "plant") else {}
    system = closed_loop(plan, **choice, flavour="native").system
    flight = cosim.fly(system, FLIGHT_STEP, experiment.stop, progress=False)
    every = round(experiment.step / FLIGHT_STEP)
    rows = range(0, flight.ticks + 1, every)
    columns = {target.partition(".")[2]: [flight[source][k] for k in rows] for source, target in
               ((link.source, link.target) for link in system.connections) if target.startswith(f"{place}.")}
    return ([n * experiment.step for n in range(len(rows))],
            {name: [f"{value:.{DIGITS.get(name, OTHER_DIGITS)}f}" for value in values]
             for name, values in columns.items()})


def outputs_of(model: Model, name: str | None, experiment: Experiment, inputs: Path | None, stop: float) -> Flight:
    """The flight of the model alone, with its preset `name`, through the inputs in a file, until `stop` (s)."""
    fmu = fmu_path("native", model.fmu)
    alone = System((Component("alone", fmu, preset(fmu, name) if name else {}),))
    return cosim.fly(alone, experiment.step, stop, inputs=inputs, progress=False)


def record(model: Model, place: str, files: Files, folder: Path) -> None:
    """Write the experiments of a model, which stands at `place` in the loop, into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for kind, (about, experiments) in files.items():
        root = Element("Experiments", name=f"{model.fmu}, {kind}", description=about)
        for experiment in experiments:
            name = experiment.scenario if place == "scenario" else model.preset
            time, columns = inputs_of(model, place, experiment)
            last = (len(time) - 1) // experiment.rows * experiment.rows
            inputs = folder / f"{experiment.name}-in.csv" if columns else None
            if inputs:
                inputs.write_text(table(time[:last + 1], {n: values[:last + 1] for n, values in columns.items()}))
            flight = outputs_of(model, name, experiment, inputs, time[last])
            rows = range(0, last + 1, experiment.rows)
            shown = {name.partition(".")[2]: [f"{flight[name][k]:.12g}" for k in rows] for name in flight}
            results = folder / f"{experiment.name}-ref.csv"
            results.write_text(table([time[k] for k in rows], shown))
            element = SubElement(root, "Experiment", name=experiment.name, description=experiment.about,
                                 tolerance=f"{TOLERANCE:g}")
            SubElement(element, "TransientSimulation", startTime="0", stopTime=f"{time[last]:.10g}",
                       stepSize=f"{experiment.step:g}")
            if name:
                SubElement(element, "Parameters", source=f"../../resources/presets/{name}.ssv")
            if inputs:
                SubElement(element, "Stimuli", source=inputs.name)
            SubElement(element, "References", source=results.name)
        (folder / f"{kind}.exp").write_bytes(xml_bytes(root))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="write to DIR/NAME/ instead")
    out = parser.parse_args().out
    for place, models, files in (("controller", LAWS.values(), OF_LAWS), ("plant", PLANTS.values(), SMOKE),
                                 ("scenario", [SCENARIO], OF_SCENARIO)):
        for model in models:
            beside = Path(str(import_module(model.module).__file__)).parent / "experiments"
            record(model, place, files, (out or beside) / model.fmu)


if __name__ == "__main__":
    main()
