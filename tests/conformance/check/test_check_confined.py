"""A hostile FMU: what it may use is limited, what it starts ends with it, and it cannot rewrite its verdict."""
import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from check_fixture import BASE_XML, members, write
from places import AHV

from cosim.conformance import check, confined
from cosim.conformance.confined import Limits

SMALL = Limits(call_s=5, memory_mb=300, file_mb=8, processes=10)


@pytest.fixture(params=[*filter(confined.works, confined.SANDBOXES), None], ids=str)
def sandbox(request, monkeypatch):
    """Each sandbox that works here, and none."""
    name = request.param
    monkeypatch.setattr("cosim.conformance.confined.sandbox", lambda: name)
    monkeypatch.setattr("cosim.conformance.dynamic.sandbox", lambda: name)
    return name


def hostile(folder, defect):
    return write(folder / "Fixture.fmu", members(defect=defect))


def limits(report):
    return [finding.found for finding in report.findings if finding.rule == "dynamic.limits"]


def left_behind():
    """Processes that the fixture started."""
    return [found for found in using("98765.4") if found.startswith("sleep")]


@pytest.mark.parametrize("defect, said", [
    ("HOGS", "more than 300 MB of memory"), ("BIG_FILE", "a file of more than 8 MB"),
    ("FORKS", "more than 10 processes")])
def test_a_limit_is_named_with_the_call_that_passed_it(tmp_path, sandbox, defect, said):
    report = check(hostile(tmp_path, defect), limits=SMALL)
    assert len(limits(report)) == 1 and limits(report)[0].startswith(f"{said}, in fmi2"), report.findings
    assert not report.passed
    assert report.sandbox == (sandbox or "none")


def test_a_process_in_a_session_of_its_own_ends_with_the_check(tmp_path, sandbox):
    report = check(hostile(tmp_path, "ESCAPES"), limits=Limits(call_s=5, processes=10_000), cycles=20)
    assert report.passed, report.findings
    assert left_behind() == []


def test_a_file_elsewhere_is_written_only_where_there_is_no_bwrap(tmp_path, sandbox, monkeypatch):
    monkeypatch.setenv("AHV_TEST_WRITES", str(tmp_path / "elsewhere.txt"))
    check(hostile(tmp_path, "WRITES"), cycles=5)
    assert (tmp_path / "elsewhere.txt").exists() == (sandbox != "bwrap")


def test_the_whole_check_has_a_time_limit(tmp_path):
    report = check(hostile(tmp_path, "SLOW"), limits=Limits(total_s=1.0))
    assert limits(report)[0].startswith("1 s for the whole check")


def test_what_the_fmu_prints_is_not_in_our_answer(tmp_path):
    done = subprocess.run([AHV, "check", hostile(tmp_path, "PRINTS"), "--json"], capture_output=True, text=True)
    assert done.returncode == 0 and json.loads(done.stdout)["passed"]


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_nothing_lives_on_when_the_check_is_killed(tmp_path, how):
    """In a temporary folder of its own, which only a SIGKILL may leave there."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    fmu = hostile(tmp_path, "STEP_HANGS")
    process = subprocess.Popen([AHV, "check", fmu, "--time-limit", "1000"], env=os.environ | {"TMPDIR": str(temporary)},
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not (marks := list(temporary.glob("*/mark.bin"))) or b"fmi2DoStep" not in marks[0].read_bytes():
        time.sleep(0.02)
    process.send_signal(how)
    process.wait(5)
    deadline = time.monotonic() + 5
    while (alive := using(temporary)) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert alive == []
    assert how == signal.SIGKILL or list(temporary.iterdir()) == []


def using(folder):
    """The command lines of processes that name `folder`, or work in it."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if str(folder) in f"{os.readlink(process / 'cwd')} {(process / 'cmdline').read_text()}":
                found.append((process / "cmdline").read_text())
        except OSError:
            continue
    return found


@pytest.mark.parametrize("identifier", ["../../../outside", "{folder}/outside", "a/../../../outside"])
def test_a_library_outside_of_the_fmu_is_not_loaded(tmp_path, identifier):
    """The library that the name leads to would leave a file if it were loaded."""
    (tmp_path / "trap.c").write_text('#include <stdio.h>\n__attribute__((constructor)) static void trap(void)'
                                     f'{{ fclose(fopen("{tmp_path}/loaded", "w")); }}\n')
    from fmus.native_compiler import cc

    cc("-shared", "-fPIC", tmp_path / "trap.c", "-o", tmp_path / "outside.so")
    name = identifier.format(folder=tmp_path)
    xml = BASE_XML.replace('modelIdentifier="Fixture"', f'modelIdentifier="{name}"')
    fmu = write(tmp_path / "Fixture.fmu", {**members(), "modelDescription.xml": xml.encode()})
    assert not check(fmu).passed
    done = subprocess.run([AHV, "run", "case1", "--controller", f"mine={fmu}"], capture_output=True, text=True)
    assert done.returncode == 2 and "modelIdentifier" in done.stderr and len(done.stderr.splitlines()) <= 3, done.stderr
    assert not (tmp_path / "loaded").exists()
