"""Runs an SSP, or one FMU, in a master that we did not write:
`python foreign.py [--cost] MASTER FILE STEP STOP OUT.npz VALUES NAME...`.

A process of its own for each run, as these masters load FMUs into their own process and some end it with them.
OUT.npz gets one array for each NAME (component.variable, all of them outputs), at 0, STEP, ..., STOP;
NaN where the master does not tell. VALUES is a JSON object of component.variable and numbers, for the masters of
`foreign_python` that ask for them. With --cost OUT.npz gets the processor time (s) of a tick instead: that of a flight
of STOP seconds without that of one a tenth as long, every signal read at every tick.
How each master has to be told what, and where its rows belong in time, is here and in docs/using-the-controller.md.
"""
import json
import os
import shutil
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
import zipfile
from functools import partial
from pathlib import Path

import foreign_python as python
import numpy as np


def libcosim(ssp, step, stop, names, values):
    """libcosim's fixed-step algorithm is Jacobi; the step comes with the SSP, in libcosim's own annotation.

    Only Reals are to be had at t = 0, by a time series; Booleans are asked for after each step.
    """
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(str(ssp))
    first, last = CosimObserver.create_time_series(), CosimObserver.create_last_value()
    execution.add_observer(first)
    execution.add_observer(last)
    rows = np.full((round(stop / step) + 1, len(names)), np.nan)
    groups = []   # reader, slave, value references, columns: one call each
    for slave in execution.slave_infos():
        known = {f"{slave.name.decode()}.{v.name.decode()}": v for v in execution.slave_variables(slave.index)}
        for kind, read in ((CosimVariableType.REAL, last.last_real_values),
                           (CosimVariableType.BOOLEAN, last.last_boolean_values)):
            mine = [i for i, n in enumerate(names) if n in known and known[n].type == kind.value]
            if mine:
                groups.append((read, slave.index, [known[names[i]].reference for i in mine], mine))
    reals = [(slave, reference, i) for read, slave, references, mine in groups if read == last.last_real_values
             for reference, i in zip(references, mine)]
    for slave, reference, _ in reals:
        first.start_time_series(slave, reference, CosimVariableType.REAL)
    for k in range(1, len(rows)):
        if not execution.step():
            raise RuntimeError(str(execution.status()))
        if k == 1:
            for slave, reference, i in reals:
                rows[0, i] = first.time_series_real_samples(slave, reference, from_step=0, sample_count=3)[2][0]
        for read, slave, references, mine in groups:
            rows[k, mine] = read(slave, references)
    return rows


def ecos(ssp, step, stop, names, values):
    """ecos steps all FMUs before it exchanges anything, which is Jacobi; the step is an argument.

    It sets parameters only if their set is named, and its CSV files have six digits: values are asked for instead.
    """
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=str(ssp), step_size=step) as simulation:
        simulation.init(0, parameter_set_name(ssp))
        readers = []
        for name in names:
            identifier = name.replace(".", "::", 1)
            for read in (simulation.get_real, simulation.get_bool, simulation.get_integer):
                try:
                    read(identifier)
                except Exception:  # ecos says "no such variable" for another type
                    continue
                readers.append((read, identifier))
                break
        rows = [[read(identifier) for read, identifier in readers]]
        for _ in range(round(stop / step)):
            simulation.step()
            rows.append([read(identifier) for read, identifier in readers])
    return np.array(rows, float)


SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"


def components(ssp):
    """Name and parameter sets of each component, in the order of the SSP."""
    found = {}
    with zipfile.ZipFile(ssp) as archive:
        for component in ET.fromstring(archive.read("SystemStructure.ssd")).iter(f"{SSD}Component"):
            bindings = component.findall(f"{SSD}ParameterBindings/{SSD}ParameterBinding")
            found[component.get("name")] = [
                ET.fromstring(archive.read(b.get("source"))) if b.get("source") else b.find(f".//{SSV}ParameterSet")
                for b in bindings]
    return found


def parameter_set_name(ssp):
    return next((s.get("name") for sets in components(ssp).values() for s in sets), None)


def start_values(ssp):
    return [(component, parameter.get("name"), parameter[0].get("value")) for component, sets in components(ssp).items()
            for parameter_set in sets for parameter in parameter_set.iter(f"{SSV}Parameter")]


def fmucontainer(ssp, step, stop, names, values):
    """fmucontainer makes an FMU of the system, with a Jacobi master inside; fmpy runs it.

    It takes neither parameter sets nor outputs from an SSP without root connectors: both are added by hand. A loop
    is cut before its first FMU, which starts from inputs that are 0: the FMUs are put in reverse, so that this is
    one whose state does not depend on its inputs. The row at t = 0 is from before the loop is closed and is left out.
    """
    import fmpy
    from fmu_manipulation_toolbox.assembly import Assembly

    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(ssp, folder)
        assembly = Assembly(ssp.name, default_step_size=step, fmu_directory=Path(folder))
        files = dict(zip(components(ssp), assembly.root.fmu_names_list))
        assembly.root.fmu_names_list.reverse()
        for name in names:
            component, _, variable = name.partition(".")
            assembly.root.add_output(files[component], variable, f"shown.{name}")
        for component, variable, value in start_values(ssp):
            assembly.root.add_start_value(files[component], variable, value)
        path = Path(folder) / "container.fmu"
        assembly.make_fmu(filename=str(path))
        result = fmpy.simulate_fmu(str(path), start_time=0.0, stop_time=stop, step_size=step, output_interval=step,
                                   output=[f"shown.{n}" for n in names], fmi_type="CoSimulation")
    rows = np.column_stack([np.asarray(result[f"shown.{n}"], float) for n in names])
    rows[0] = np.nan
    return rows


MASTERS = {"libcosim": libcosim, "ecos": ecos, "fmucontainer": fmucontainer, "ours": python.ours,
           "ours gauss-seidel": partial(python.ours, algorithm="gauss-seidel"), "fmpy": python.fmpy,
           "gemseo-fmu": python.gemseo, "fmugym": python.fmugym,
           "pathsim-fmi": python.pathsim, "CoFmuPy": python.cofmupy, "syssimx": python.syssimx,
           "pyssp-standard": python.pyssp}


REPEATS = 3


def cost(fly, step, stop):
    """Processor time (s) of a tick of fly(stop), start-up left out: the quicker of several flights of each length."""
    short = stop / 10
    took = {short: [], stop: []}
    fly(step)   # loads what is loaded once
    for _ in range(REPEATS):
        for end, found in took.items():
            begun = time.process_time()
            fly(end)
            found.append(time.process_time() - begun)
    return (min(took[stop]) - min(took[short])) / ((stop - short) / step)


if __name__ == "__main__":
    measured = "--cost" in sys.argv
    master, file, step, stop, out, values, *names = [word for word in sys.argv[1:] if word != "--cost"]

    def fly(end):
        return MASTERS[master](Path(file), float(step), end, names, json.loads(values))

    if measured:
        np.savez(out, cost=cost(fly, float(step), float(stop)))
    else:
        np.savez(out, rows=fly(float(stop)), names=names)
    # Not by the way of atexit: as its library goes, pythonfmu 0.7.0 writes to memory that it freed, which these masters
    # do not prevent (`master/instance.py` does). Once in many runs the process was aborted, its rows written.
    sys.stdout.flush()
    os._exit(0)
