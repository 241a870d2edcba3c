"""What docs/python.md, its examples and its notebooks say, done: here, and with an installed wheel elsewhere."""
import os
import re
import shutil
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import jupyter_client
import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient

import cosim

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))
LAWS, PLANTS = {"AhvController": 2.4, "PidController": 19.0}, ("AhvPlant", "RigidPlant")  # altitude error, ft


def examples_in(folder, native_fmus, packages):
    """Standard output of docs/python.md's examples, run in `folder` with `packages` on the path."""
    for source in ("pid.py", "rigid_plant.py"):
        shutil.copy(DOCS / "examples" / source, folder)
    environment = {**os.environ, "AHV_FMUS": str(native_fmus["AhvPlant"].parent), "PYTHONPATH": str(packages)}
    done = subprocess.run([sys.executable, ROOT / "tests" / "documented.py", DOCS / "python.md"], cwd=folder,
                          capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_examples_of_the_page_run_and_find_what_it_says(tmp_path, native_fmus):
    said = examples_in(tmp_path, native_fmus, ROOT)
    found = {(law, plant): float(error) for law, plant, error in
             re.findall(r"^(\w+) +(\w+) +([\d.]+) ft$", said, re.MULTILINE)}
    assert {*found} == {(law, plant) for law in LAWS for plant in PLANTS}
    assert all(found[law, plant] <= limit for law, limit in LAWS.items() for plant in PLANTS)
    assert "This flight has no signal plant.hh; did you mean plant.h?" in said
    assert re.search(r"^False \d+\.\d+ plant \(AhvPlant.fmu\) answered Discard", said, re.MULTILINE)
    assert (tmp_path / "flight.png").stat().st_size > 10_000


def test_the_examples_run_from_an_installed_wheel_elsewhere(tmp_path, native_fmus):
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", tmp_path, ROOT], check=True)
    wheel, = tmp_path.glob("ahv-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {"cosim/py.typed", "fmus/py.typed", "cosim/library.py"} <= {*names}
    installed, elsewhere = tmp_path / "installed", tmp_path / "else where"
    subprocess.run([*pip, "install", "--no-deps", "--target", installed, wheel], check=True)
    elsewhere.mkdir()
    where = subprocess.run([sys.executable, "-c", "import cosim.library; print(cosim.library.__file__)"], cwd=elsewhere,
                           env={**os.environ, "PYTHONPATH": str(installed)}, check=True, capture_output=True, text=True)
    assert Path(where.stdout.strip()).is_relative_to(installed)
    assert "PidController  RigidPlant" in examples_in(elsewhere, native_fmus, installed)


@pytest.fixture(scope="module")
def strangers(tmp_path_factory):
    """The FMUs that stock pythonfmu makes of docs/examples."""
    folder = tmp_path_factory.mktemp("strangers")
    for source in ("pid.py", "rigid_plant.py"):
        subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", DOCS / "examples" / source, "-d", folder],
                       check=True, capture_output=True)
    return {path.stem: path for path in folder.glob("*.fmu")}


def loop(scenario, controller, plant, case):
    wires = {("scenario", "controller"): ("V_command", "h_command"),
             ("scenario", "plant"): [f"scale_{s}" for s in ("thrust", "lift", "drag", "moment", "forces")],
             ("plant", "controller"): ("V", "h", "gamma", "theta", "Q"),
             ("controller", "plant"): ("fuel_ratio", "elevator")}
    return cosim.System([cosim.Component("scenario", scenario, cosim.preset(scenario, case)),
                         cosim.Component("controller", controller), cosim.Component("plant", plant)],
                        [cosim.Connection(f"{a}.{n}", f"{b}.{n}") for (a, b), names in wires.items() for n in names])


@pytest.mark.parametrize("case,stop,feet,feet_per_second", [
    ("hold", 60, 0.01, 0.01), ("case1", 100, 19.0, 0.6), ("case2", 300, 29.0, 0.8)])
@pytest.mark.parametrize("plant", PLANTS)
def test_the_strangers_controller_flies_both_plants(case, stop, feet, feet_per_second, plant, strangers, native_fmus):
    fmus = {**native_fmus, **strangers}
    flight = cosim.fly(loop(fmus["AhvScenario"], fmus["PidController"], fmus[plant], case), step=0.01, stop=stop)
    assert flight.finished
    assert abs(flight["plant.h"] - flight["controller.h_reference"]).max() < feet
    assert abs(flight["plant.V"] - flight["controller.V_reference"]).max() < feet_per_second
    elevator = np.degrees(flight["controller.elevator"])
    assert elevator.min() > 0 and elevator.max() < 19.9  # never at its stop


def test_the_strangers_plant_is_our_vehicle_without_its_modes(strangers, native_fmus):
    fmus = {**native_fmus, **strangers}
    ours, theirs = (cosim.fly(loop(fmus["AhvScenario"], fmus["AhvController"], fmus[plant], "case1"), 0.01, 100)
                    for plant in PLANTS)
    assert abs(ours["plant.h"] - theirs["plant.h"]).max() < 0.01
    assert abs(ours["plant.V"] - theirs["plant.V"]).max() < 0.01


@pytest.mark.parametrize("name", ["pid.py", "rigid_plant.py"])
def test_an_example_fits_on_a_screen(name):
    assert len((DOCS / "examples" / name).read_text().splitlines()) <= 60


# --- notebooks ------------------------------------------------------------------------------------------

@pytest.fixture
def in_kernels(native_fmus, monkeypatch):
    monkeypatch.setenv("AHV_FMUS", str(native_fmus["AhvPlant"].parent))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_what_it_promises(path, in_kernels):
    notebook = nbformat.read(path, 4)
    assert all(not cell.get("outputs") and not cell.get("execution_count") for cell in notebook.cells)
    NotebookClient(notebook, timeout=120, kernel_name="python3",
                   resources={"metadata": {"path": str(path.parent)}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    kinds = {kind for output in shown for kind in output.get("data", ())}
    assert {"text/html", "image/png"} <= kinds
    assert any("finished." in output.get("data", {}).get("text/html", "") for output in shown)
    assert not any("progress value" in str(output) for output in shown)  # bars go when the flight has ended


LONG = """
import cosim, pathlib, sys
sys.path.insert(0, {tests!r})
import small
flight = cosim.fly(small.pair(pathlib.Path({fmu!r}), substeps=200.0), step=0.001, stop=3000, record=["left.y"])
print(flight.finished, flight.message, len(flight.time) == flight.ticks + 1 > 1)
"""


def test_an_interrupted_cell_shows_a_bar_and_keeps_what_was_flown(in_kernels, tmp_path):
    import small

    code = LONG.format(tests=str(ROOT / "benchmarks"), fmu=str(small.build(tmp_path)))
    manager, client = jupyter_client.manager.start_new_kernel(kernel_name="python3")
    said, bars = [], []

    def hear(message):
        content = message["content"]
        said.append(content.get("text", "") + "".join(content.get("traceback", ())))
        if "<progress" in content.get("data", {}).get("text/html", ""):
            bars.append(content["data"]["text/html"])
            if len(bars) == 3:
                threading.Thread(target=manager.interrupt_kernel).start()

    try:
        client.execute_interactive(code, timeout=60, output_hook=hear)
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
    assert len(bars) >= 3 and "left, right: " in bars[0] and "of 3000 s" in bars[0]
    assert re.search(r"False Interrupted at t = [\d.]+ s\. True", "".join(said)), said
