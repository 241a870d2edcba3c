"""What docs/ecosystems.md says, done; of gemseo and fmugym in the environments that `make peers` makes."""
import os
import re
import subprocess
import sys

import environments
import importers
import pytest

PAGE = importers.ROOT / "docs" / "ecosystems.md"
GEMSEO = importers.ROOT / ".venv-peers" / "gemseo-fmu" / "bin" / "python"


def run(folder, native_fmus, *words):
    done = subprocess.run([str(word) for word in words], cwd=folder, capture_output=True, text=True, env={
        **os.environ, "PYTHONPATH": str(importers.ROOT), "AHV_FMUS": str(native_fmus["AhvPlant"].parent)})
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_examples_of_the_page_run_and_find_what_it_says(tmp_path, native_fmus):
    said = run(tmp_path, native_fmus, sys.executable, importers.ROOT / "tests" / "documented.py", PAGE)
    assert re.search(r"^\d+\.\d\d s: ", said, re.MULTILINE) and (tmp_path / "episode.png").stat().st_size > 10_000
    altitude, fuel = map(float, re.search(r"\[ *([\d.]+) +([\d.]+)\] \(2, 2\)", said).groups())
    assert 2.3 < altitude < 2.4 and fuel > 1.0
    mass, gain = map(float, re.search(r"shares of the variance: \[([\d.e-]+),([\d.e-]+)\]", said).groups())
    assert mass < 0.05 and 0.9 < gain <= 1.0  # a linear law explains nearly all of it


@pytest.mark.peers
@pytest.mark.skipif(not GEMSEO.exists(), reason="`make peers` makes the environment")
def test_gemseo_finds_a_better_gain(tmp_path, native_fmus):
    example = re.search(r'^```python title="gemseo"\n(.*?)^```', PAGE.read_text(), re.MULTILINE | re.DOTALL)[1]
    (tmp_path / "example.py").write_text(example)
    said = run(tmp_path, native_fmus, GEMSEO, "example.py")
    gain, error = map(float, re.search(r"^\[([\d.]+)\] ([\d.]+)$", said, re.MULTILINE).groups())
    assert gain > 0.5 and error < 2.315


@pytest.mark.peers
@pytest.mark.skipif(not environments.FMUGYM.exists(), reason="`make peers` makes the environment")
def test_a_step_costs_less_than_half_of_fmugyms_and_a_reset_a_tenth(tmp_path, native_fmus):
    said = run(tmp_path, native_fmus, sys.executable, environments.__file__, "--rounds", 3)
    costs = re.findall(r"^\| (the \w+) \|.*\| (\w+) \| ([\d.]+) \| ([\d.]+) \|$", said, re.MULTILINE)
    print(said)
    assert len(costs) == 4
    for (what, name, step, reset), (same, other, *theirs) in zip(costs[::2], costs[1::2]):
        assert (what, name, other) == (same, "ours", "fmugym")
        assert float(step) < 0.5 * float(theirs[0]) and float(reset) < 0.1 * float(theirs[1])
