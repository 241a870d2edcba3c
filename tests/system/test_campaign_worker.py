"""What a worker keeps loaded."""
from types import SimpleNamespace

import pytest
import small

from cosim.campaign.worker import LoadedSystems
from cosim.master.algorithms import method
from cosim.master.fly import fly_loaded


@pytest.mark.parametrize("claims,kept", [((), [1, 2, 2]), (("canBeInstantiatedOnlyOncePerProcess",), [1, 1, 1])])
def test_laws_with_an_fmu_that_allows_one_instance_in_a_process_take_turns(tmp_path, claims, kept):
    system = small.pair(small.build(tmp_path, claims=claims), small.build(tmp_path))
    job = SimpleNamespace(systems={"one": system, "other": system}, record={"one": None, "other": None}, tolerance=None)
    loaded, found = LoadedSystems(job, tmp_path), []
    try:
        for law in ("one", "other", "one"):
            assert fly_loaded(loaded.ready(law, {}), method("jacobi"), 0.01, 10).finished
            found.append(len(loaded.kept.masters))
    finally:
        loaded.close()
    assert found == kept
