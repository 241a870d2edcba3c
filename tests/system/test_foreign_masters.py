"""One SSP in our master and in three that we did not write: the same flight.

What differs is the clock only: libcosim counts nanoseconds, ecos adds up steps, ours multiplies. With their clocks our
master gives their numbers to the last bit; so does fmucontainer, whose clock is ours.
"""
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import peers
import pyarrow.parquet
import pytest
from command import ahv
from places import ROOT

HERE = Path(__file__).parent
MASTERS = ("libcosim", "ecos", "fmucontainer")
TOLERANCE = 1e-9   # of a signal's nominal value
STEP = 0.01


def ours(ssp, stop, folder):
    """Names of the signals, and their rows."""
    ahv("simulate", ssp, "--algorithm", "jacobi", "--step", STEP, "--stop", stop, "--out", folder, "--json")
    table = pyarrow.parquet.read_table(folder / "signals.parquet").drop(["time"])
    return table.column_names, np.column_stack([column.to_numpy() for column in table.columns])


def theirs(master, ssp, stop, names, folder):
    out = folder / f"{master}.npz"
    words = [sys.executable, HERE / "foreign.py", master, ssp, STEP, stop, out, "{}", *names]
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=300, cwd=folder,
                          env={**peers.environment(), "TMPDIR": str(folder)})   # where ecos leaves a folder behind
    assert done.returncode == 0, done.stderr[-2000:]
    return np.load(out)["rows"]


def nominals(ssp, names, folder):
    """The nominal value of each output, 1 where its FMU gives none."""
    import foreign

    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(folder / "unpacked")
        root = foreign.ET.fromstring(archive.read("SystemStructure.ssd"))
    known = {}
    for component in root.iter(f"{foreign.SSD}Component"):
        fmu = folder / "unpacked" / component.get("source")
        for v in fmpy.read_model_description(str(fmu), validate=False).modelVariables:
            known[f"{component.get('name')}.{v.name}"] = float(v.nominal or 1.0)
    return np.array([known[n] for n in names])


def assert_same_flight(ssp, stop, folder):
    """Flies `ssp` in all masters, prints the largest difference of each and asserts that it is none."""
    names, rows = ours(ssp, stop, folder / "ours")
    scale = nominals(ssp, names, folder)
    print(f"\n{ssp.name}, {len(names)} signals, {len(rows)} rows: largest difference from `ahv simulate`, "
          f"as a part of the signal's nominal value")
    worst = {}
    for master in MASTERS:
        found = theirs(master, ssp, stop, names, folder)
        assert found.shape == rows.shape
        assert np.isfinite(found[1:]).all(), master   # what a master does not tell at t = 0 is NaN
        difference = np.nanmax(np.abs(found - rows) / scale, axis=0, initial=0.0)
        worst[master] = difference.max()
        print(f"  {master:14}{worst[master]:10.1e}   {names[difference.argmax()]}")
    assert max(worst.values()) <= TOLERANCE, worst


@pytest.mark.parametrize("case,flavour,stop", [("case1", "native", 100), ("case1", "python", 10),
                                               ("case2", "native", 60)])
def test_the_closed_loop_flies_the_same(case, flavour, stop, tmp_path):
    ahv("ssp", case, "--flavour", flavour, "--out", tmp_path / f"{case}.ssp")
    assert_same_flight(tmp_path / f"{case}.ssp", stop, tmp_path)


def test_a_system_of_another_make_written_by_hand_flies_the_same(handmade, tmp_path):
    assert_same_flight(handmade, 10, tmp_path)


def test_the_handmade_system_is_the_oscillator_that_it_says(handmade, tmp_path):
    """m = 2.5, k = 40, d = 0.5 come from its parameter sets; the closed form of the free oscillation."""
    names, rows = ours(handmade, 1, tmp_path / "ours")
    t = STEP * np.arange(len(rows))
    decay, omega = 0.5 / 5, np.sqrt(40 / 2.5 - (0.5 / 5) ** 2)
    exact = np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    assert np.abs(rows[:, names.index("mass.position")] - exact).max() < 0.1   # two Jacobi steps late at 10 ms


PAGE = ROOT / "docs" / "using-the-controller.md"
EXAMPLES = [text for text in re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
            if "OMSimulator" not in text]   # which cannot be installed here


@pytest.mark.parametrize("text", EXAMPLES, ids=["libcosim", "ecos", "fmucontainer", "fmpy"])
def test_the_examples_of_the_page_run(text, tmp_path):
    ahv("ssp", "case1", "--out", tmp_path / "case1.ssp")
    (tmp_path / "fmus").symlink_to(ROOT / "fmus")
    done = subprocess.run([sys.executable, "-c", text], cwd=tmp_path, capture_output=True, text=True, timeout=300,
                          env={**peers.environment(), "TMPDIR": str(tmp_path)})
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="session")
def handmade(tmp_path_factory):
    """The SSP in handmade/, its FMUs built by pythonfmu's own command."""
    folder = tmp_path_factory.mktemp("handmade")
    for source in ("mass.py", "spring.py"):
        subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", HERE / "handmade" / source, "-d", folder],
                       check=True, capture_output=True)
    path = folder / "oscillator.ssp"
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("SystemStructure.ssd", "spring.ssv"):
            archive.write(HERE / "handmade" / name, name)
        for fmu in ("Mass.fmu", "Spring.fmu"):
            archive.write(folder / fmu, f"resources/{fmu}")
    return path
