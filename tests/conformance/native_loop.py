"""Scenario, controller and plant flown through fmpy alone, without this project's master."""
import shutil
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave

import cosim.vehicle.scenario_model as scenario

COMMANDS = ["V_command", "h_command"]
SCALES = ["scale_thrust", "scale_lift", "scale_drag", "scale_moment", "scale_forces"]
MEASURES = ["V", "h", "gamma", "theta", "Q"]
ACTIONS = ["fuel_ratio", "elevator"]


@dataclass
class Recording:
    """A run as the controller saw it; all signals by "component.name" in `signals`."""
    step: float
    controller_inputs: dict[str, list[float]]
    controller_outputs: dict[str, list[float]]
    signals: dict[str, list[float]] | None = None


class Loaded:
    """One FMU instantiated, its variables by name."""

    def __init__(self, path: Path):
        self.folder = Path(fmpy.extract(str(path)))
        self.description = fmpy.read_model_description(str(self.folder))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.slave = FMU2Slave(guid=self.description.guid, unzipDirectory=str(self.folder), instanceName=path.stem,
                               modelIdentifier=path.stem)
        self.slave.instantiate()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.slave.freeInstance()
        shutil.rmtree(self.folder)

    def names(self, causality: str, kind: str = "Real") -> list[str]:
        return [v.name for v in self.variables.values() if v.causality == causality and v.type == kind]

    def references(self, names) -> list[int]:
        return [self.variables[name].valueReference for name in names]

    def set(self, **values):
        self.slave.setReal(self.references(values), list(values.values()))

    def get(self, *names) -> list[float]:
        return self.slave.getReal(self.references(names))

    def begin(self):
        self.slave.setupExperiment()
        self.slave.enterInitializationMode()

    def shut(self):
        self.slave.exitInitializationMode()


@cache
def record(fmus: Path, case: str, seconds: float = 100.0, step: float = 0.01) -> Recording:
    """Fly `case` with the FMUs in a folder, in Gauss-Seidel order, and keep every signal of every tick."""
    paths = [fmus / f"{name}.fmu" for name in ("AhvScenario", "AhvController", "AhvPlant")]
    with Loaded(paths[0]) as s, Loaded(paths[1]) as c, Loaded(paths[2]) as p:
        for member in (s, c, p):
            member.begin()
        s.set(**scenario.PRESETS[case])
        inputs = [*MEASURES, *COMMANDS]
        outputs = {member: member.names("output") for member in (s, c, p)}
        seen: dict[str, list[float]] = {name: [] for name in inputs}
        rows = {member: [] for member in (s, c, p)}

        def pass_on(step_of):
            """One tick: `step_of` steps a member, or ends its initialisation."""
            step_of(s)
            p.set(**dict(zip(SCALES, s.get(*SCALES))))
            values = [*p.get(*MEASURES), *s.get(*COMMANDS)]
            for name, value in zip(inputs, values):
                seen[name].append(value)
            c.set(**dict(zip(inputs, values)))
            step_of(c)
            p.set(**dict(zip(ACTIONS, c.get(*ACTIONS))))
            step_of(p)
            for member in (s, c, p):
                rows[member].append(member.get(*outputs[member]))

        pass_on(Loaded.shut)
        for k in range(round(seconds / step)):
            pass_on(lambda member, t=k * step: member.slave.doStep(t, step))

        columns = {member: dict(zip(outputs[member], map(list, zip(*rows[member])))) for member in rows}
        signals = {f"{label}.{name}": values for label, member in (("scenario", s), ("controller", c), ("plant", p))
                   for name, values in columns[member].items()}
        return Recording(step, seen, columns[c], signals)
