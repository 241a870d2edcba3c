"""The closed loop saved in flight and flown on: in the same instances, and in fresh ones."""
from contextlib import ExitStack

import pytest
from flying import running, step

from cosim.vehicle.closed_loop import CLOSED_LOOP

ORDER = {"scenario": "AhvScenario", "controller": "AhvController", "plant": "AhvPlant"}
STEP, SAVED_AT, UNTIL = 0.01, 3700, 5500  # ticks: t = 37 s, and past the first change of coefficients


@pytest.fixture(params=["python", "native"])
def fmus(request, python_fmus, native_fmus):
    return {"python": python_fmus, "native": native_fmus}[request.param]


def loop(stack, fmus):
    case2 = {}
    for name in ORDER:
        path = fmus[ORDER[name]]
        values = {}
        if name == "scenario":
            with running(path) as probe:
                values = probe.file.preset("case2")
        case2[name] = stack.enter_context(running(path, **values))
    return case2


def fly(instances, first, last):
    """Gauss-Seidel from tick to tick; the trajectory of all outputs."""
    trajectory = []
    for k in range(first, last):
        for name, instance in instances.items():
            for source, target, shared in CLOSED_LOOP:
                if target == name:
                    instance.set(dict(zip(shared, instances[source].get(shared))))
            step(instance, k * STEP, STEP)
        trajectory.append([instance.get(instance.file.names("output")) for instance in instances.values()])
    return trajectory


def test_flies_on_to_the_last_bit(fmus):
    with ExitStack() as stack:
        flying = loop(stack, fmus)
        fly(flying, 0, SAVED_AT)
        blobs = {name: instance.saved() for name, instance in flying.items()}
        expected = fly(flying, SAVED_AT, UNTIL)

        for name, instance in flying.items():
            instance.restore(blobs[name])
        assert fly(flying, SAVED_AT, UNTIL) == expected

        fresh = loop(stack, fmus)
        for name, instance in fresh.items():
            instance.restore(blobs[name])
        assert fly(fresh, SAVED_AT, UNTIL) == expected
