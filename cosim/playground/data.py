"""What the page knows: cases, laws, plants, their FMUs' variables and presets, metrics, the master's lists of calls.

All of it is read from the FMUs, the registry and the master; the page has no table of its own but layout.json.
"""
import ast
import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ..master import program as P
from ..master.algorithms import method
from ..master.algorithms.base import Experiment, Fixed
from ..master.declared import Variable
from ..master.description import Description
from ..master.evaluate import word
from ..master.fmu import FmuFile
from ..master.loaded import Master, open_files
from ..master.loop_compiled import ARRAYS
from ..master.measures import Expression
from ..master.recording import Recorder
from ..master.system import System, Value
from ..vehicle.closed_loop import FOLLOWS, LIMITS, closed_loop, fmu_path
from ..vehicle.limits import ACTUATORS, PAUSE, SHARE
from ..vehicle.metrics import METRICS
from ..vehicle.registry import LAWS, MODELS, PLANTS, SCENARIO, Model
from ..vehicle.scenarios import BUILT_IN
from ..vehicle.signals import STANDS_IN
from ..vehicle.trim import ARRIVED

FLAVOUR = "native"
ALGORITHM, STEP = "gauss-seidel", 0.01  # the default ones of `ahv run`
LAYOUT = Path(__file__).parent / "page" / "layout.json"
OPERATORS = {ast.Add: "+", ast.Sub: "-"}
Plan = dict[str, list[Any]]


def about() -> dict[str, Any]:
    """All that the page knows but the modules, as JSON goes. Raises UsageError for an FMU that is not built."""
    return {
        "version": version("ahv"), "step": STEP, "algorithm": ALGORITHM,
        "scenarios": {name: {"stop": each.stop, "presets": each.presets} for name, each in BUILT_IN.items()},
        "scenario": named(SCENARIO), "laws": {word: named(law) for word, law in LAWS.items()},
        "plants": {word: named(plant) for word, plant in PLANTS.items()},
        "fmus": {name: declared(name) for name in MODELS},
        "plans": {law: {plant: plan(closed_loop(BUILT_IN["hold"], law, plant, FLAVOUR).system) for plant in PLANTS}
                  for law in LAWS},
        "program": {"ARRAYS": ARRAYS, **{n: x for n, x in vars(P).items() if n.isupper() and isinstance(x, int)}},
        "metrics": {name: {"unit": metric.unit, "expression": tree(metric.expression.tree)}
                    for name, metric in METRICS.items()},
        "layout": layout(),
        "stands_in": STANDS_IN, "follows": FOLLOWS, "limits": LIMITS,
        "remarks": {"share": SHARE, "pause": PAUSE, "arrived": ARRIVED, "actuators": ACTUATORS},
    }


def layout() -> dict[str, Any]:
    """layout.json: what is in which section and panel; each line with the expression of its signal."""
    found: dict[str, Any] = json.loads(LAYOUT.read_text(encoding="utf-8"))
    for line in (line for panel in found["panels"] for line in panel["lines"]):
        line["expression"] = tree(Expression(line["signal"]).tree)
    return found


def tree(part: ast.expr) -> Any:
    """An expression on signals as the page reads it: a signal's name, or [function or operator, part, ...]."""
    if name := word(part):
        return name
    if isinstance(part, ast.BinOp):
        return [OPERATORS[type(part.op)], tree(part.left), tree(part.right)]
    assert isinstance(part, ast.Call) and isinstance(part.func, ast.Name)
    return [part.func.id, *map(tree, part.args)]


def named(model: Model) -> dict[str, Any]:
    """What the registry says of a model."""
    return {"fmu": model.fmu, "summary": model.summary, "preset": model.preset, "gains": model.gains}


def declared(name: str) -> dict[str, Any]:
    """What the FMU of our model `name` declares: parameters and outputs, presets. Raises UsageError where it is not
    built."""
    with FmuFile.open(fmu_path(FLAVOUR, name)) as file:
        kept = [v for v in file.scalars if v.causality in ("parameter", "output")]
        presets = sorted(path.stem for path in (file.folder / "resources" / "presets").glob("*.ssv"))
        return {"file": file.path.name, "sha256": file.sha256,
                "variables": {v.name: variable(v, file.start(v.name), file.description) for v in kept},
                "presets": {preset: {n: file.checked(n, value, name) for n, value in file.preset(preset).items()}
                            for preset in presets}}


def variable(v: Variable, start: Value, description: Description) -> dict[str, Any]:
    """One variable; what it does not declare is left out. `display` is its display unit and that one's factor."""
    unit = description.unit_of(v)
    display = next(([d.name, d.factor] for d in unit.displays if d.name == v.display_unit), None) if unit else None
    found = {"causality": v.causality, "unit": "" if v.unit == "1" else v.unit, "display": display, "start": start,
             "min": v.min, "max": v.max, "description": v.description}
    return {key: value for key, value in found.items() if value is not None}


def plan(system: System) -> Plan:
    """The calls of the master, in order: those of `initial` once, before the FMUs leave the initialisation, those of
    `tick` on every tick. A call is [set|get, component, its variables, the signals that they come from or go to], or
    [step, component]. `columns` are the signals, as `ahv run` records them.

    Raises ValueError for a system with an algebraic loop at the start.
    """
    with open_files(system) as files:
        master = Master(system, files)
        try:
            chosen = method(ALGORITHM)
            algorithm = chosen.algorithm(master, chosen.options, Experiment(0.0, STEP, 1, Recorder(master.columns)))
            assert isinstance(algorithm, Fixed)  # the same calls on every tick
            return {"initial": [batch(master, names) for (names,) in master.exchanged],
                    "tick": [call(master, code, index) for code, index, *_ in algorithm.ops.tolist()],
                    "columns": [column.name for column in master.columns]}
        finally:
            master.close()


def batch(master: Master, names: list[str]) -> list[Any]:
    """Variables that are set or read together before the start."""
    component = names[0].partition(".")[0]
    sets = names[0] in master.targets
    return ["set" if sets else "get", component, [name.partition(".")[2] for name in names],
            [master.targets[name].source if sets else name for name in names]]


def call(master: Master, code: int, index: int) -> list[Any]:
    """One row of a program."""
    if code == P.STEP:
        return ["step", master.instances[index].name]
    group = master.wiring.every_group[index]
    component = master.instances[group.owner].name
    return batch(master, [f"{component}.{name}" for name in group.names])
