"""The tests of `test_campaign`, but for those of kills, with campaigns flown in this process: what `make mutants` can
afford to try hundreds of times."""
import json
from contextlib import contextmanager

import campaigns
import pytest
import test_campaign
from distributed import Client, LocalCluster
from test_campaign import *  # noqa: F403

from cosim.campaign import worker
from cosim.errors import UsageError


@contextmanager
def connected(scheduler, workers, tls, dashboard):
    """A client of a worker that is a thread of this process."""
    with (LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
          Client(cluster) as client):
        yield client


def fly(file, out, *words, status=0):
    """What `ahv campaign FILE --out OUT --json WORD...` says; `status` is 2 if it is to be refused."""
    try:
        found = json.dumps(campaigns.campaign(file, out, resume="--resume" in words))
    except UsageError as refused:
        assert status == 2
        return str(refused)
    assert status == 0
    return found


@pytest.fixture(scope="module", autouse=True)
def inside():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(campaigns.campaigns, "connected", connected)
        patch.setattr(worker, "PATIENCE_S", 600.0)  # the machine may be busy with other trials
        patch.setitem(campaigns.FILE, "timeout_s", 600.0)
        patch.setattr(test_campaign, "fly", fly)
        patch.setattr(test_campaign, "ahv", lambda word, file, option, out, *words: fly(file, out, *words))
        yield
