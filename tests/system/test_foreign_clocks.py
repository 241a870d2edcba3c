"""Why foreign masters differ from ours in the last digits: their clocks. With these, the same numbers come out."""
from ctypes import c_double, c_int
from itertools import accumulate, repeat

import numpy as np
import pytest
from command import ahv
from test_foreign_masters import STEP, theirs

from cosim.master.connections import checked_connections
from cosim.master.initialise import initialise, order
from cosim.master.instance import Instance
from cosim.master.loaded import open_files
from cosim.ssp.load import load_ssp

TICKS = 2000


def nanoseconds(k):
    return k * round(STEP * 1e9) / 1e9


SUMS = list(accumulate(repeat(STEP, TICKS), initial=0.0))
CLOCKS = {   # start and length of step k
    "libcosim": lambda k: (nanoseconds(k), nanoseconds(k + 1) - nanoseconds(k)),
    "ecos": lambda k: (SUMS[k], STEP),
}


def flown(path, clock):
    """Names and rows of all Real outputs, by the plainest Jacobi loop."""
    with load_ssp(path) as found, open_files(found) as files:
        targets = checked_connections(found, files)
        instances = {name: Instance(file, name) for name, file in files.items()}
        for component in found.components:
            instances[component.name].set(component.values)
        initialise(order(found, files, targets), instances, targets, 0.0, TICKS * STEP)
        shown = {name: [n for n in file.names("output") if file.variable(n).type == "Real"]
                 for name, file in files.items()}
        rows = []
        for k in range(TICKS + 1):
            values = {f"{name}.{n}": x for name, instance in instances.items()
                      for n, x in zip(shown[name], instance.get(shown[name]))}
            rows.append(list(values.values()))
            if k == TICKS:
                break
            for name, instance in instances.items():
                instance.set({target.partition(".")[2]: values[link.source] for target, link in targets.items()
                              if target.startswith(name + ".")})
            for instance in instances.values():
                begun, length = map(c_double, clock(k))
                instance.check(instance.call("fmi2DoStep", begun, length, c_int(1)), "fmi2DoStep")
        for instance in instances.values():
            instance.close()
    return list(values), np.array(rows)


@pytest.mark.parametrize("master", CLOCKS)
def test_with_the_clock_of_another_master_its_numbers_come_out(master, tmp_path):
    path = tmp_path / "case1.ssp"
    ahv("ssp", "case1", "--flavour", "native", "--out", path)
    names, rows = flown(path, CLOCKS[master])
    assert np.array_equal(rows, theirs(master, path, TICKS * STEP, names, tmp_path))
