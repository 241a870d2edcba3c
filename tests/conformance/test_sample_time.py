"""A discrete law runs at its instants whatever the communication step, in both flavours."""
import math

import pytest
import sampled_model
from native_loop import Loaded
from one_platform import one_platform

from cosim.conformance import check
from fmus.builder import build

SHOWN = ("seen", "runs", "at")


@pytest.fixture(scope="module", params=["native", "python"])
def path(request, tmp_path_factory):
    with one_platform():
        return build(sampled_model, request.param, tmp_path_factory.mktemp("sampled"))


@pytest.fixture(scope="module")
def law(path):
    with Loaded(path) as member:
        member.fresh = member.slave.getFMUState()
        yield member


def begun(law, start=0.0, **values):
    law.slave.setFMUState(law.fresh)
    law.slave.setupExperiment(startTime=start)
    law.slave.enterInitializationMode()
    law.set(**values)
    law.slave.exitInitializationMode()


def stepped(law, step, count, start=0.0, summed=False):
    """What it shows after each of `count` steps, before which the signal is the time."""
    rows, t = [], start
    for k in range(count):
        law.set(signal=t)
        law.slave.doStep(t, step)
        t = t + step if summed else start + (k + 1) * step
        rows.append(law.get(*SHOWN))
    return rows


@pytest.mark.parametrize("summed", [False, True])
@pytest.mark.parametrize("start", [0.0, 3.7])
@pytest.mark.parametrize("step", [0.01, 0.03, 0.07, 0.1])
def test_it_runs_at_multiples_of_its_time_and_holds_in_between(law, step, start, summed):
    begun(law, start)
    count = round(30 / step)
    for k, (seen, runs, at) in enumerate(stepped(law, step, count, start, summed)):
        instants = math.floor(((k + 1) * step - 1e-6) / 0.1) + 1  # before the end of the step
        assert runs == instants, k
        assert at == pytest.approx(start + (instants - 1) * 0.1, abs=1e-11)
        assert at - step - 1e-9 < seen <= at + 1e-9  # the signal of the step that the instant lies in


@pytest.mark.parametrize("step, runs", [(0.2, 2), (0.25, 3), (1.0, 10), (0.1 + 0.2, 3), (0.1 * (1 + 1e-10), 1)])
def test_a_long_step_has_several_instants(law, step, runs):
    begun(law)
    law.slave.doStep(0.0, step)
    assert law.get("runs", "at", "length") == [runs, pytest.approx((runs - 1) * 0.1), 0.1]


def test_it_runs_at_the_start_in_steps_however_short(law):
    begun(law, 5.0)
    assert stepped(law, 1e-9, 3, 5.0) == [[5.0, 1.0, 5.0]] * 3


def test_before_it_ran_it_shows_its_start_and_afterwards_no_input_at_once(law):
    begun(law, signal=7.0)
    assert law.get(*SHOWN) == [7.0, 0.0, 0.0]
    law.slave.doStep(0.0, 0.05)
    law.set(signal=8.0)
    assert law.get(*SHOWN) == [7.0, 1.0, 0.0]
    law.slave.doStep(0.05, 0.05)
    assert law.get(*SHOWN) == [7.0, 1.0, 0.0]
    assert law.slave.getBoolean(law.references(["is_far"])) == [True]


def test_another_sample_time_and_the_prepared_numbers_are_the_instants_own(law):
    begun(law, sample_time=0.25)
    stepped(law, 0.1, 4)
    assert law.get("runs", "at", "length") == [2.0, 0.25, 0.25]


def test_a_state_put_back_knows_its_instants(law):
    begun(law, 1.0)
    stepped(law, 0.07, 2, 1.0)
    state = law.slave.getFMUState()
    later = stepped(law, 0.03, 20, 1.14)
    begun(law)
    law.slave.setFMUState(state)
    assert stepped(law, 0.03, 20, 1.14) == later
    law.slave.freeFMUState(state)


def test_it_says_so_in_fmis_terms_and_is_checked_clean(path, law):
    outputs = [v for v in law.description.modelVariables if v.causality == "output"]
    assert [v.variability for v in outputs] == ["discrete"] * 5
    assert all(unknown.dependencies == [] for unknown in law.description.outputs)
    report = check(path, dynamic=path.parent.name == "native")
    assert [f for f in report.findings if f.severity != "note"] == []
