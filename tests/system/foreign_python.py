"""Importers written in Python, and ours, for `foreign.py`: each a function of a file, a step and a stop (s), names and
values, which gives an array of the values of the names at 0, STEP, ..., STOP; NaN where the importer does not tell.

The file is an SSP, for importers that wire systems, or one FMU. Those that do not read SSP are wired by hand, and where
they initialise each FMU alone, the inputs get `values` (component.variable -> number) before: what our master has at
the start. None of these importers' packages is imported before it is asked for.
"""
import json
import tempfile
import zipfile
from pathlib import Path

import numpy as np


def ours(file, step, stop, names, values, algorithm="jacobi"):
    """Our master, all outputs recorded."""
    import cosim

    if file.suffix == ".ssp":
        with cosim.load_ssp(file) as system:
            flight = cosim.fly(system, step, stop, algorithm=algorithm, progress=False)
    else:
        system = cosim.System([cosim.Component("fmu", file, {n.partition(".")[2]: x for n, x in values.items()})])
        flight = cosim.fly(system, step, stop, algorithm=algorithm, progress=False)
    return np.column_stack([flight[name] for name in names])


def fmpy(file, step, stop, names, values):
    """FMPy's simulate_fmu; it flies one FMU, ours or a container."""
    import fmpy

    given = {n.partition(".")[2]: x for n, x in values.items()}
    result = fmpy.simulate_fmu(str(file), stop_time=stop, step_size=step, output_interval=step,
                               output=inner(names, file), start_values=given, fmi_type="CoSimulation")
    return np.column_stack([result[name] for name in inner(names, file)])


def inner(names, file):
    """The names in the FMU: a container's variables are called component.variable, those of another are fmu.NAME."""
    return list(names) if container(file) else [name.partition(".")[2] for name in names]


def container(file):
    with zipfile.ZipFile(file) as archive:
        return "resources/container.json" in archive.namelist()


def gemseo(file, step, stop, names, values):
    """gemseo-fmu: a discipline that is executed once; its outputs are the courses over time."""
    from gemseo_fmu.disciplines.fmu_discipline import FMUDiscipline

    given = {n.partition(".")[2]: x for n, x in values.items()}
    discipline = FMUDiscipline(file, input_names=list(given) or None, output_names=inner(names, file),
                               initial_time=0.0, final_time=stop, time_step=step)
    found = discipline.execute({n: np.array([x]) for n, x in given.items()})
    return np.column_stack([np.ravel(found[name]) for name in inner(names, file)])


def fmugym(file, step, stop, names, values):
    """fmugym: an environment of gymnasium; actions are the inputs, observations the outputs, in single precision."""
    import fmugym as package

    inputs, outputs, nothing = (package.VarSpace(word) for word in ("inputs", "outputs", "random"))
    for name in values:
        inputs.add_var_box(name.partition(".")[2], -1e9, 1e9)
    for name in inner(names, file):
        outputs.add_var_box(name, -1e9, 1e9)

    class Environment(package.FMUGym):
        init_states: dict = {}  # noqa: RUF012  (the base class sets into it)

        def compute_reward(self, *_):
            return 0.0

        def _get_input_noise(self):
            return 0.0

        def _get_output_noise(self):
            return 0.0

    environment = Environment(package.FMUGymConfig(str(file), 0.0, stop, step, step, inputs=inputs, outputs=outputs,
                                                   random_vars=nothing))
    given = {n.partition(".")[2]: x for n, x in values.items()}
    action = np.array([given[name] for name in environment.input_dict])
    rows = [np.full(len(names), np.nan)]   # it reads outputs at the start before an action is set
    order = [list(environment.output_dict).index(name) for name in inner(names, file)]
    rows += [np.asarray(environment.step(action)[0])[order] for _ in range(round(stop / step))]
    environment.close()
    return np.array(rows, float)


class Wiring:
    """What an SSP says, for importers that do not read one: FMU files in `folder`, values, connections."""

    def __init__(self, ssp, folder, values):
        from foreign import ET, SSD, components, start_values

        with zipfile.ZipFile(ssp) as archive:
            archive.extractall(folder)
            root = ET.fromstring(archive.read("SystemStructure.ssd"))
        self.files = {c.get("name"): Path(folder) / c.get("source") for c in root.iter(f"{SSD}Component")}
        self.links = [(c.get("startElement"), c.get("startConnector"), c.get("endElement"), c.get("endConnector"))
                      for c in root.iter(f"{SSD}Connection")]
        self.values = {name: {} for name in components(ssp)}
        for component, variable, text in start_values(ssp):
            self.values[component][variable] = {"true": True, "false": False}.get(text) if text in (
                "true", "false") else float(text)
        for full, value in values.items():
            component, _, variable = full.partition(".")
            self.values[component][variable] = value


def pathsim(file, step, stop, names, values):
    """pathsim-fmi: a block for each FMU, which steps when the simulation's time reaches the beginning of a step; its
    outputs are then those of the step's end."""
    from pathsim import Connection, Simulation
    from pathsim_fmi import CoSimulationFMU

    with tempfile.TemporaryDirectory() as folder:
        wiring = Wiring(file, folder, values)
        blocks = {name: CoSimulationFMU(str(path), name, wiring.values[name], step)
                  for name, path in wiring.files.items()}
        simulation = Simulation(list(blocks.values()), [
            Connection(blocks[a][x], blocks[b][y]) for a, x, b, y in wiring.links], dt=step, log=False)
        readers = [(blocks[c].outputs, v) for c, _, v in (name.partition(".") for name in names)]
        rows = [[outputs[v] for outputs, v in readers]]
        for _ in range(round(stop / step)):
            simulation.timestep(step)
            rows.append([outputs[v] for outputs, v in readers])
    return np.array(rows, float)


def cofmupy(file, step, stop, names, values):
    """CoFmuPy: a configuration in JSON, Jacobi. It sets Reals only, and inputs to 0 unless they are given; its rows are
    labelled with the beginning of the step."""
    from cofmupy import Coordinator

    with tempfile.TemporaryDirectory() as folder:
        wiring = Wiring(file, folder, values)
        reals = {name: {k: x for k, x in given.items() if not isinstance(x, bool)}
                 for name, given in wiring.values.items()}
        connections = [{"source": {"id": a, "variable": x, "unit": ""}, "target": {"id": b, "variable": y, "unit": ""}}
                       for a, x, b, y in wiring.links]
        config = Path(folder) / "config.json"
        config.write_text(json.dumps({
            "fmus": [{"id": name, "name": name, "path": str(path), "initialization": reals[name]}
                     for name, path in wiring.files.items()],
            "connections": connections, "cosim_method": "jacobi", "iterative": False, "root": folder,
            "edge_sep": " -> "}))
        coordinator = Coordinator()
        coordinator.start(str(config))
        for _ in range(round(stop / step)):
            coordinator.do_step(step)
        found = coordinator.get_results()
    rows = np.column_stack([np.ravel(found[tuple(name.split(".", 1))]) for name in names])
    return np.vstack([np.full(len(names), np.nan), rows])


def syssimx(file, step, stop, names, values):
    """syssimx: components with units, which pint reads; Jacobi."""
    from syssimx import Connection, FMUComponent, System
    from syssimx.system.algorithms.jacobi import JacobiAlgorithm

    with tempfile.TemporaryDirectory() as folder:
        wiring = Wiring(file, folder, values)
        system = System("loop")
        system.set_algorithm(JacobiAlgorithm())
        parts = {}
        for name, path in wiring.files.items():
            part = parts[name] = FMUComponent(name, str(path))
            system.add_component(part)
            known = part.get_parameters()
            part.set_parameters(**{k: x for k, x in wiring.values[name].items() if k in known})
        for a, x, b, y in wiring.links:
            system.add_connection(Connection(a, x, b, y))
        system.initialize(0.0)

        def row():
            return [number(parts[c].outputs[v].get()) for c, _, v in (name.partition(".") for name in names)]

        rows = [row()]
        system.run(0.0, stop, step, progress=lambda *_: rows.append(row()))
    return np.array(rows, float)


def number(value):
    """A quantity's number, in its own unit."""
    return float(getattr(value, "magnitude", value))


def pyssp(file, step, stop, names, values):
    """pyssp-standard reads an SSP: its components and connections must be those of the file. It flies nothing."""
    from pyssp_standard.ssp import SSP

    with tempfile.TemporaryDirectory() as folder:
        wiring = Wiring(file, folder, {})
        with SSP(file, mode="r") as ssp, ssp.system_structure as ssd:
            found = {e.component.name if hasattr(e, "component") else e.name for e in ssd.system.elements}
            links = {(c.start_element, c.start_connector, c.end_element, c.end_connector) for c in ssd.connections()}
    if found != set(wiring.files) or links != set(wiring.links):
        raise RuntimeError(f"it reads the components {found} and {len(links)} connections")
    return np.empty((0, len(names)))
