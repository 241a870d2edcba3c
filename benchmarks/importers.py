"""Our FMUs in the importers of others: what each makes of them, how far it is from ours, and what a tick costs.

    make peers                              the environments, the tests, and docs/importers.md
    .venv/bin/python benchmarks/importers.py [--rounds N] [--out FILE.md]

Importers whose pins do not fit beside ours have an environment of their own, below `.venv-peers/`, from a list in
`requirements/peers/`. Each flight is a process of its own (`tests/system/foreign.py`); costs are measured in rounds, in
which all importers take turns, as processor time, which a busy machine disturbs less than the clock on the wall.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np
import peers

ROOT = Path(__file__).parent.parent
FOREIGN = ROOT / "tests" / "system" / "foreign.py"
PAGE = ROOT / "docs" / "importers.md"
STEP, STOP, LONG = 0.01, 10.0, 100.0   # s; LONG for costs
LOOP, CONTROLLER, ONE, SSP = "the loop", "the controller", "the loop as one FMU", "the SSP"
EXACT = 1e-9


@dataclass(frozen=True)
class Importer:
    """An importer and what it is given; `limit` is the largest difference allowed, as a part of a signal's nominal."""
    name: str
    what: str
    package: str
    environment: str = ""             # below .venv-peers/; "" is ours
    master: str = ""                  # its name in foreign.py, if it is another
    reference: str = "ours"           # what of ours it is compared with
    limit: float = EXACT
    remark: str = ""
    fails: str = ""                   # what it says where it cannot; `remark` says why
    fails3: str = ""                  # what it says where it cannot fly FMUs of FMI 3.0; "" if it can

    @property
    def python(self) -> Path:
        """The interpreter that has it."""
        return ROOT / ".venv-peers" / self.environment / "bin" / "python" if self.environment else Path(sys.executable)

    @property
    def key(self) -> str:
        """Its name in foreign.py."""
        return self.master or self.name


IMPORTERS = [
    Importer("FMPy", CONTROLLER, "fmpy", master="fmpy"),
    Importer("gemseo-fmu", CONTROLLER, "gemseo-fmu", "gemseo-fmu"),
    Importer("fmugym", CONTROLLER, "fmugym", "python", limit=1e-5,
             remark="observations are single precision; it reads none at the start"),
    Importer("libcosim", LOOP, "libcosimpy", remark="its clock counts nanoseconds; it reads no FMI 3.0",
             fails3="Unable to create execution"),
    Importer("ecos", LOOP, "ecospy", remark="its clock adds up steps"),
    Importer("fmucontainer", LOOP, "fmu-manipulation-toolbox", remark="its row at the start is from before the loop is "
             "closed, and is left out"),
    Importer("pathsim-fmi", LOOP, "pathsim-fmi", "python", reference="ours gauss-seidel",
             remark="its events make it Gauss-Seidel, and so is ours here; inputs at the start are given"),
    Importer("CoFmuPy", LOOP, "cofmupy", "cofmupy", limit=0.05, remark="it steps the scenario before the loop, so that "
             "commands come one tick early; it sets Reals only, and inputs to 0 unless they are given at the start"),
    Importer("FMPy", ONE, "fmpy", master="fmpy"),
    Importer("gemseo-fmu", ONE, "gemseo-fmu", "gemseo-fmu"),
    Importer("fmugym", ONE, "fmugym", "python", limit=1e-5, remark="observations are single precision"),
    Importer("syssimx", LOOP, "syssimx", "python", fails="communication step 0 s is not a positive number",
             fails3="Only FMI 2.0 is supported",
             remark="it reads the FMUs and their units; at the start it takes a step of 0 s, which FMI 2.0 does not "
                    "allow (section 4.2.2)"),
    Importer("pyssp-standard", SSP, "pyssp-standard", "python",
             remark="reads components and connections; flies nothing"),
]
NOT_HERE = ("OMSimulator cannot be tried here: its package loads the program from a server of its own while it is "
            "installed.")


class Files:
    """What is flown, in `folder`: Case 1 as an SSP and (of FMI 2.0) as one FMU, the controller; the signals and start
    values. `flavour` is native or native-fmi3."""

    def __init__(self, folder: Path, flavour: str = "native"):
        import cosim
        from cosim.ssp.container import write_container
        from cosim.ssp.write import write
        from cosim.vehicle import scenarios
        from cosim.vehicle.closed_loop import closed_loop
        from fmus.places import found

        plan = scenarios.load("case1")
        self.folder, self.loop = folder, closed_loop(plan, flavour=flavour).system
        self.places = {LOOP: folder / "case1.ssp", ONE: folder / "Loop.fmu", SSP: folder / "case1.ssp",
                       CONTROLLER: found(flavour, "AhvController")}
        write(self.places[LOOP], plan.name, self.loop, STEP, plan.stop)
        if flavour == "native":
            write_container(self.places[ONE], plan.name, self.loop, STEP, plan.stop)
        start = cosim.fly(self.loop, STEP, STEP, progress=False)
        wired = {link.target: float(start[link.source][0]) for link in self.loop.connections}
        controller = variables(self.places[CONTROLLER])
        self.values = {LOOP: wired, ONE: {}, SSP: {}, CONTROLLER: {
            **{f"fmu.{v.name}": float(v.start) for v in controller if v.causality == "input"},
            "fmu.V_command": 7800.0}}
        self.names = {LOOP: list(start), ONE: list(start), SSP: [], CONTROLLER: [
            f"fmu.{v.name}" for v in controller if v.causality == "output"]}
        nominal = {f"{c.name}.{v.name}": v.nominal for c in self.loop.components for v in variables(c.fmu)}
        nominal |= {f"fmu.{v.name}": v.nominal for v in controller}
        self.nominal = {what: np.array([abs(float(nominal[n] or 1.0)) for n in names])
                        for what, names in self.names.items()}
        self.known: dict[tuple[str, str], np.ndarray] = {}

    def reference(self, importer: Importer) -> np.ndarray:
        """The rows of ours that an importer is compared with."""
        what = LOOP if importer.what == ONE else importer.what
        if (importer.reference, what) not in self.known:
            ours = Importer(importer.reference, what, "ahv")
            self.known[importer.reference, what] = self.run(ours, STOP)["rows"]
        return self.known[importer.reference, what]

    def run(self, importer: Importer, stop: float, *options: str) -> dict[str, np.ndarray]:
        """What foreign.py leaves of a flight. Raises RuntimeError with what it said where it fails."""
        out = self.folder / "out.npz"
        out.unlink(missing_ok=True)
        words = [importer.python, FOREIGN, *options, importer.key, self.places[importer.what], STEP, stop, out,
                 json.dumps(self.values[importer.what]), *self.names[importer.what]]
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=600,
                              cwd=self.folder, env={**peers.environment(), "PYTHONPATH": str(ROOT),
                                                    "TMPDIR": str(self.folder)})
        if done.returncode or not out.exists():
            raise RuntimeError(f"{done.stdout}\n{done.stderr}")
        with np.load(out) as found:
            return dict(found)

    def difference(self, importer: Importer) -> float:
        """The largest difference from ours over all signals and ticks, as a part of a signal's nominal value; 0 where
        nothing is flown."""
        rows = self.run(importer, STOP)["rows"]
        if not rows.size:
            return 0.0
        expected = self.reference(importer)
        if rows.shape != expected.shape or not np.isfinite(rows[1:]).all():
            raise RuntimeError(f"{importer.name} gives {rows.shape} values, or some that are not finite")
        return float(np.nanmax(np.abs(rows - expected) / self.nominal[importer.what]))

    def cell(self, importer: Importer) -> str:
        """The largest difference as the page has it."""
        return f"{self.difference(importer):.1e}".replace("0.0e+00", "0")

    def cost(self, importer: Importer) -> float:
        """Processor time of a tick, s."""
        return float(self.run(importer, LONG, "--cost")["cost"])


def variables(fmu: Path) -> list:
    """What the FMU at `fmu` declares."""
    from cosim.master.fmu import FmuFile

    with FmuFile.open(fmu) as file:
        return file.description.variables


def version(importer: Importer) -> str:
    """The version of its package."""
    text = f"from importlib.metadata import version; print(version({importer.package!r}))"
    done = subprocess.run([importer.python, "-c", text], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def of_fmi3(files: Files, importer: Importer) -> str:
    """The page's cell on FMI 3.0; `files` are of that version."""
    if importer.what not in (LOOP, CONTROLLER):  # our container and our SSP are for FMI 2.0
        return "–"
    return "fails" if importer.fails3 else files.cell(importer)


def measure(files: Files, files3: Files, rounds: int) -> list[list[str]]:
    """The rows of the page."""
    flown = [i for i in IMPORTERS if not i.fails and i.what != SSP]
    ours = [Importer("ours", what, "ahv") for what in (LOOP, CONTROLLER)]
    costs: dict[Importer, list[float]] = {i: [] for i in [*ours, *flown]}
    for turn in range(rounds):
        for importer, found in costs.items():
            found.append(files.cost(importer))
            print(f"round {turn + 1}, {importer.name}, {importer.what}: {1e6 * found[-1]:.1f} us", file=sys.stderr)
    own = {i.what: 1e6 * median(costs[i]) for i in ours}
    rows = []
    for importer in IMPORTERS:
        cells = [importer.name, version(importer), importer.what]
        if importer.fails:
            rows.append([*cells, "fails", of_fmi3(files3, importer), "–", "–", importer.remark])
        elif importer.what == SSP:
            files.difference(importer)
            rows.append([*cells, "reads it", of_fmi3(files3, importer), "–", "–", importer.remark])
        else:
            base = own[LOOP if importer.what == ONE else importer.what]
            rows.append([*cells, files.cell(importer), of_fmi3(files3, importer),
                         f"{1e6 * median(costs[importer]):.1f}", f"{base:.1f}", importer.remark])
    return rows


def page(rows: list[list[str]], rounds: int, signals: int) -> str:
    """docs/importers.md."""
    head = ["importer", "version", "is given", "largest difference", "FMI 3.0", "µs a tick", "ours", "remark"]
    lines = ["# Our FMUs in other importers", "",
             "With this page you can see which tools fly our FMUs, how far their flights are from ours, and what they "
             "cost. `make peers`",
             "tests every line and writes the page; importers whose versions do not fit beside ours get an environment "
             "below `.venv-peers/`.", "",
             "| " + " | ".join(head) + " |", "|" + "---|" * len(head),
             *("| " + " | ".join(row) + " |" for row in rows), "",
             f"**The loop** is Case 1 with the native FMUs, {STOP:g} s in steps of {1000 * STEP:g} ms, all "
             f"{signals} signals at every tick. Importers that read no SSP are wired in Python.",
             "**The controller** is `AhvController.fmu` alone: 100 ft/s more are commanded, the measurements stay. "
             "**The loop as one FMU** is what",
             "`ahv container case1` writes. Differences are parts of a signal's nominal value, from our master with "
             "the algorithm `jacobi`;",
             "the column **FMI 3.0** is the same with the FMUs of `native-fmi3`.",
             f"Costs are processor time on one machine, the median of {rounds} rounds in which all took turns; every "
             "signal is read at every tick,",
             "in the way that the importer has.", "",
             NOT_HERE, "",
             "All ports of our FMUs are Reals, flags 0 or 1, since pathsim-fmi, CoFmuPy and others read every output "
             "with `fmi2GetReal`. Units are written",
             "so that UDUNITS and pint read them. How to use the FMUs in these tools stands in "
             "[Use the controller](using-the-controller.md#in-the-tools).", ""]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--out", type=Path, default=PAGE)
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        files = Files(Path(folder))
        with tempfile.TemporaryDirectory() as other:
            rows = measure(files, Files(Path(other), "native-fmi3"), words.rounds)
    words.out.write_text(page(rows, words.rounds, len(files.names[LOOP])))
    print(words.out, file=sys.stderr)


if __name__ == "__main__":
    main()
