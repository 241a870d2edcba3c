"""An FMU that answers Fatal in a campaign's worker: none of its functions is called any more; the next run flies."""
from dataclasses import replace
from pathlib import Path

import pytest
import small

from cosim.campaign.plan import Job
from cosim.campaign.sampling import Sampler
from cosim.campaign.worker import LoadedSystems, Outcome, Request
from fmus.native_compiler import cc

FATAL = small.FAULTS.index("fatal")
FATAL_INIT = small.FAULTS.index("fatal_init")


@pytest.fixture
def fmus(tmp_path, monkeypatch):
    """Two files of the small FMU; a call after Fatal leaves a file `called`."""
    code = Path(small.__file__).with_name("small.c").read_text()
    counted = "calls_after_fatal += dead;"
    assert counted in code
    code = code.replace(counted, f'if (dead) fclose(fopen("{tmp_path / "called"}", "w"));')
    source = tmp_path / "small.c"
    source.write_text(code)
    cc("-O2", "-shared", "-fPIC", "-w", f"-I{small.HEADERS}", source, "-o", tmp_path / "small.so")
    monkeypatch.setattr(small, "library", lambda folder: tmp_path / "small.so")
    return small.build(tmp_path), small.build(tmp_path, direct=None)


@pytest.mark.parametrize("fault", [FATAL_INIT, FATAL])
def test_no_function_is_called_after_fatal_and_the_next_run_flies(fmus, tmp_path, monkeypatch, fault):
    job = Job("key", {"law": small.pair(*fmus)}, {"law": ["left.y"]}, 0.01, 50, "jacobi", {}, 60.0, {"law": ()},
              Sampler("random", 1, 3, 1), 0.0, False, 1, {})
    systems = LoadedSystems(job, Path("/"))
    monkeypatch.setattr(systems, "outcome", lambda request, flight, status: Outcome(request, status, flight.message))
    one = Request(0, "law", {}, {}, False, False)
    bad = replace(one, values={"left.fault": fault, "left.fault_time": 0.2})
    try:
        found = [systems.fly(request) for request in (one, bad, one, bad)]
    finally:
        systems.close()
    assert [o.status for o in found[::2]] == ["finished"] * 2
    assert all("answered Fatal to fmi2" in o.message and o.status in ("error", "departed") for o in found[1::2])
    assert not (tmp_path / "called").exists()
