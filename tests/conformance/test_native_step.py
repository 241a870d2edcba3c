"""`ahv bench step`: an FMU by turns with its bare functions and with another edition, here itself."""
import json
import subprocess
import sys

from places import ROOT


def test_a_step_is_timed_beside_its_bare_functions_and_another_edition(native_fmus, python_fmus):
    fmu = native_fmus["AhvScenario"]
    done = subprocess.run([sys.executable, ROOT / "benchmarks" / "native_step.py", "--law", "AhvScenario",
                           "--against", fmu, "--json"], check=True, capture_output=True, text=True)
    found = json.loads(done.stdout)["AhvScenario"]
    other = found["against"][str(fmu)]
    assert 0.005 < found["bare_us"] < found["native_us"] < found["python_us"]
    assert found["ratio_spread"][0] <= found["ratio"] <= found["ratio_spread"][1] and found["ratio"] > 1
    assert 0.7 < other["ratio"] < 1.4  # the same functions, twice
