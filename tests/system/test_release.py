"""What `make dist` writes: a wheel that flies without a compiler, and a release folder."""
import hashlib
import json
import os
import re
import subprocess
import sys
import zipfile
from functools import partial
from pathlib import Path

import pytest
from places import ROOT

from cosim.master import compile_loop
from cosim.vehicle.registry import MODELS
from fmus import release

CAMPAIGN = """
name: small
scenario: case1
controllers: [neural, resilient]
runs: 4
seed: 1
stop: 5
success: {altitude: altitude_error_ft.max_abs < 20}
dispersions:
  scenario.scale_lift: {distribution: sinusoid, amplitude: 0.4, period: 40}
"""


@pytest.fixture(scope="module")
def folder(native_fmus, native_fmi3_fmus, tmp_path_factory) -> Path:
    """A release folder."""
    target = tmp_path_factory.mktemp("release")
    compile_loop.everywhere()
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", target], cwd=ROOT, check=True,
                   capture_output=True)
    release.write(target)
    return target


@pytest.fixture(scope="module")
def wheel(folder) -> Path:
    found, = folder.glob("*.whl")
    return found


def test_the_wheel_is_for_any_platform_and_carries_what_is_compiled(wheel, native_fmus, native_fmi3_fmus):
    assert wheel.name.endswith("-py3-none-any.whl")
    with zipfile.ZipFile(wheel) as archive:
        carried = {name: archive.read(name) for name in archive.namelist() if name.endswith(".fmu")}
        loops = {name for name in archive.namelist() if name.startswith("cosim/master/built/")}
        needed = archive.read(next(n for n in archive.namelist() if n.endswith("/METADATA"))).decode()
    assert carried == {f"fmus/dist/{place}/{name}.fmu": path.read_bytes() for place, fmus in
                       (("native", native_fmus), ("native-fmi3", native_fmi3_fmus)) for name, path in fmus.items()}
    assert loops == {f"cosim/master/built/{compile_loop.name(platform)}" for platform in compile_loop.PLATFORMS}
    assert re.search(r"^Requires-Dist: platformdirs", needed, re.MULTILINE)
    assert not re.search(r"^Requires-Dist: ziglang(?!.*extra)", needed, re.MULTILINE)


def test_the_sums_are_of_all_files(folder):
    told = dict(reversed(line.split("  ")) for line in (folder / "SHA256SUMS").read_text().splitlines())
    there = {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
             for path in folder.rglob("*") if path.is_file() and path.name != "SHA256SUMS"}
    assert told == there and {f"native-fmi3/{name}.fmu" for name in MODELS} < set(told)


def test_the_bill_of_materials_has_what_spdx_wants(folder):
    bill = json.loads((folder / "ahv.spdx.json").read_text())
    assert (bill["spdxVersion"], bill["dataLicense"], bill["SPDXID"]) == ("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", bill["creationInfo"]["created"])
    assert bill["creationInfo"]["creators"] and re.fullmatch(r"https://[^#]+", bill["documentNamespace"])
    elements = [bill, *bill["packages"], *bill["files"]]
    known = [element["SPDXID"] for element in elements]
    assert len(set(known)) == len(known) and all(re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", one) for one in known)
    for element in elements[1:]:
        assert element["licenseConcluded"] and element["copyrightText"]
    for file in bill["files"]:
        content = (folder / file["fileName"]).read_bytes()
        assert {c["algorithm"]: c["checksumValue"] for c in file["checksums"]} == {
            "SHA1": hashlib.sha1(content).hexdigest(), "SHA256": hashlib.sha256(content).hexdigest()}
    ends = {(r["spdxElementId"], r["relatedSpdxElement"]) for r in bill["relationships"]}
    assert {one for pair in ends for one in pair} == set(known)
    assert {p["name"] for p in bill["packages"]} == {"ahv", "fmi-standard", "musl", "casadi", "ziglang"}


def test_a_release_with_one_version_of_an_fmu_is_refused(native_fmus, native_fmi3_fmus, tmp_path, monkeypatch):
    (tmp_path / "native").mkdir()
    (tmp_path / "native" / "Lonely.fmu").write_bytes(b"")
    monkeypatch.setattr(release, "written", lambda: tmp_path)
    with pytest.raises(RuntimeError, match=r"Lonely\.fmu of FMI 3 is not built; ahv build writes it"):
        release.write(tmp_path / "out")


@pytest.fixture(scope="module")
def fresh(wheel, tmp_path_factory) -> Path:
    """A folder with an environment that has the wheel and nothing of the checkout."""
    place = tmp_path_factory.mktemp("fresh")
    subprocess.run([sys.executable, "-m", "venv", place / "env"], check=True)
    uv = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--python", place / "env" / "bin" / "python"]
    subprocess.run([*uv, f"{wheel}[campaign]", "spdx-tools"], check=True)
    return place


def run(place: Path, program: str, *words, status: int = 0) -> subprocess.CompletedProcess[str]:
    """A program of the fresh environment, run in its folder."""
    variables = {"PATH": os.environ["PATH"], "HOME": str(place), "XDG_CACHE_HOME": str(place / "cache")}
    done = subprocess.run([place / "env" / "bin" / program, *map(str, words)], cwd=place, env=variables,
                          capture_output=True, text=True)
    assert done.returncode == status, done.stdout + done.stderr
    return done


@pytest.mark.slow
def test_the_wheel_flies_checks_and_runs_campaigns_without_a_compiler(fresh, folder):
    ahv = partial(run, fresh, "ahv")
    carried, checkout, compiler, loop = run(
        fresh, "python", "-c", "import fmus.places as p, importlib.util as u, cosim.master.compile_loop as c; "
                               "print(p.CARRIED, p.CHECKOUT, u.find_spec('ziglang'), c.library())").stdout.split()
    assert carried.startswith(str(fresh)) and (checkout, compiler) == ("False", "None")
    assert loop.startswith(str(fresh / "env"))

    for flavour in ("native", "native-fmi3"):
        found = json.loads(ahv("run", "case1", "--flavour", flavour, "--json").stdout)
        assert found["finished"] and found["altitude_error_ft"]["max_abs"] < 2.8
    assert json.loads(ahv("run", "case1", "--json", "--stop", "1").stdout)["flavour"] == "native"

    for place in ("native", "native-fmi3"):
        assert "It loads and flies" in ahv("check", f"{carried}/{place}/AhvController.fmu").stdout

    (fresh / "small.yaml").write_text(CAMPAIGN)
    found = json.loads(ahv("campaign", "small.yaml", "--json").stdout)
    assert {law: told["statuses"] for law, told in found["controllers"].items()} == {
        "neural": {"finished": 4}, "resilient": {"finished": 4}}

    refused = ahv("build", "AhvScenario", status=2).stderr
    assert "pip install ziglang" in refused
    ahv("build", "AhvScenario", "--flavour", "python")
    built = list((fresh / "cache").rglob("*.fmu"))
    assert [path.name for path in built] == ["AhvScenario.fmu"] and fresh / "env" not in built[0].parents

    run(fresh, "pyspdxtools", "-i", folder / "ahv.spdx.json")
