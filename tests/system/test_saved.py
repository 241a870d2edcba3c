"""A flight of FMI 3.0 with events that is saved and gone on from is the one that was not interrupted."""
import numpy as np
import pytest
import small3

import cosim
from cosim.master.fly import fly
from cosim.master.isolated import fly_isolated
from cosim.master.state import read_state
from cosim.master.system import Component, Connection, System


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    fmu, events = (small3.build(tmp_path_factory.mktemp("saved"), events=events) for events in (False, True))
    parts = Component("a", fmu, {"period": 0.3, "text_in": "words"}), Component("b", events, {"x1": -0.5})
    return System(parts, (Connection("a.y", "b.u"), Connection("b.y", "a.u", 0.5), Connection("a.count", "b.level_in")))


@pytest.mark.parametrize("flown", [fly, fly_isolated, lambda *a, **k: fly(*a, **k, plain=True)])
@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi,hold=linear", "multi-rate,b=2,hold=linear", "iterated"])
def test_the_rest_is_equal_to_the_last_bit(system, tmp_path, algorithm, flown):
    whole = flown(system, 0.1, 2.0, algorithm)
    flown(system, 0.1, 1.2, algorithm, save=tmp_path / "at.state")
    rest = flown(system, 0.1, 2.0, algorithm, restore=read_state(tmp_path / "at.state"))
    assert rest.finished and rest.ticks == 8 and len(rest.time) == 9
    assert np.array_equal(rest.time, whole.time[-9:]) and np.array_equal(rest.signals, whole.signals[-9:])


def test_the_library_saves_and_restores(system, tmp_path):
    file = str(tmp_path / "at.state")
    whole = cosim.fly(system, 0.1, 2.0, progress=False)
    cosim.fly(system, 0.1, 1.0, save=file, progress=False)
    rest = cosim.fly(system, 0.1, 2.0, restore=file, progress=False)
    assert rest["b.y"].tolist() == whole["b.y"].tolist()[-11:] and rest.time[0] == 1.0
    for arguments, words in (({"start": 0.0}, "^start = 0.0 is not allowed: it must be left out with restore"),
                             ({"stop": 0.5}, "^stop = 0.5 is not allowed: it must be a number of seconds after"),
                             ({"restore": "none.state"}, "There is no state none.state")):
        with pytest.raises(cosim.UsageError, match=words):
            cosim.fly(system, 0.1, **{"stop": 2.0, "restore": file, **arguments}, progress=False)
