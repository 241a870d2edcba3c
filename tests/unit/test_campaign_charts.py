"""What the report's pictures show."""
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pytest

from cosim.campaign.charts import drivers, envelopes, histograms, over_time, probability, scatter, wide
from cosim.campaign.labels import Label
from cosim.campaign.statistics import Results
from cosim.vehicle.metrics import HEADLINES, METRICS, OVER_TIME

FLOWN = SimpleNamespace(law="x", column="controller")
LABELS = {name: label for name, (label, _) in OVER_TIME.items()}
JUDGED_BY = {name: METRICS[name] for name in HEADLINES}


def errors(*runs):
    """errors.parquet of runs of law `x`: (times, altitude errors, velocity errors) each."""
    return pa.table({"controller": pa.array(["x"] * len(runs), pa.string()), **{
        name: pa.array([run[i] for run in runs], pa.list_(pa.float64()))
        for i, name in enumerate(("time", "altitude_error_ft", "velocity_error_fps"))}})


def test_curves_have_the_times_of_the_rows_where_no_run_reaches_the_end():
    axes = envelopes([FLOWN], errors(([0, 5, 10], [0, 1, 2], [0, 0, 0]),
                                                        ([0, 5], [0, 3], [0, 2])), LABELS, 0.0, 100.0).axes
    for axis, expected in zip(axes, ([0, 2, 2], [0, 1, 0])):
        assert axis.lines[0].get_xdata().tolist() == [0, 5, 10] and axis.lines[0].get_ydata().tolist() == expected
        assert axis.get_xlim() == (0, 100)
    flying = axes[2].lines[0]
    assert (flying.get_xdata().tolist(), flying.get_ydata().tolist()) == ([0, 5, 10, 10, 100], [100, 100, 50, 0, 0])


def test_runs_that_reach_the_end_fly_to_the_end():
    flying = envelopes([FLOWN], errors(([0, 5], [0, 1], [0, 0])), LABELS, 0.0, 5.0).axes[2].lines[0]
    assert (flying.get_xdata().tolist(), flying.get_ydata().tolist()) == ([0, 5], [100, 100])


def test_bands_are_quantiles_over_the_runs_that_still_fly():
    runs = [([0, 1], [0, float(k)], [0, 0]) for k in range(21)]
    axis = envelopes([FLOWN], errors(*runs), LABELS, 0.0, 1.0).axes[0]
    ends = [{float(y) for x, y in band.get_paths()[0].vertices if x == 1} for band in axis.collections]
    assert ends == [{0, 20}, {1, 19}]


def test_rows_of_runs_that_ended_are_left_empty():
    time, found = over_time(errors(([0], [7], [1]), ([0, 2], [8, 9], [1, 1])), OVER_TIME)
    assert time.tolist() == [0, 2]
    assert np.array_equal(found["altitude_error_ft"], [[7, np.nan], [8, 9]], equal_nan=True)
    assert over_time(errors(), OVER_TIME)[1]["altitude_error_ft"].shape == (0, 0)


@pytest.mark.parametrize("values,expected", [
    ([1, 1, 2, 60], True), ([1, 1, 2, 40], False), ([0, 1, 2, 600], False), ([-1, 1, 600], False), ([], False),
    ([np.nan], False), ([1, 1, np.inf], False),
])
def test_positive_values_of_different_size_get_a_logarithmic_axis(values, expected):
    assert wide(np.array(values, float)) is expected


def results(law="x", runs=40, **columns):
    """Runs that fail where a is above 0.75; the altitude error is 10 a, b has nothing to do with it."""
    a = (np.arange(runs) + 0.5) / runs
    rows = {"controller": [law] * runs, "run": list(range(runs)), "success": a < 0.75, "a.a": a,
            "a.b": np.resize([0.2, 0.9, 0.4, 0.6, 0.1], runs), "status": ["finished"] * runs, **{
                name: 10 * a if name == "altitude_error_ft.max_abs" else np.full(runs, 3.0) for name in METRICS},
            **columns}
    return Results.of(law, pa.table(rows), "controller")


def test_dots_are_the_shares_of_successes():
    axis = probability([results(), results("y", 4)]).axes[0]
    assert [dot[0].get_xdata() for dot in axis.containers] == [0.75, 0.75]
    assert [tick.get_text() for tick in axis.get_yticklabels()] == ["x", "y"]


def runs_in(axis):
    return sum(stairs.get_data().values.sum() for stairs in axis.patches)


def test_histograms_show_every_run_of_the_metrics_that_laws_are_judged_by():
    axes = histograms([results()], JUDGED_BY).axes
    assert [axis.get_xlabel() for axis in axes] == [f"{name} ({METRICS[name].unit})" for name in HEADLINES]
    assert [runs_in(axis) for axis in axes] == [40] * len(HEADLINES)
    assert axes[0].get_xscale() == "linear"


def test_drivers_come_first_where_they_correlate_most():
    axes = drivers([results()], ["a.b", "a.a"], "altitude_error_ft.max_abs", {}).axes
    assert [tick.get_text() for tick in axes[0].get_yticklabels()] == ["a.a", "a.b"]
    assert axes[1].patches[0].get_width() == pytest.approx(1)
    assert axes[0].patches[0].get_width() == pytest.approx(0.75, abs=0.05)
    assert abs(axes[0].patches[1].get_width()) < 0.3
    assert axes[2].patches[0].get_width() > 0.5 and axes[2].patches[1].get_width() < 0.2


def test_a_scatter_tells_failures_from_successes():
    labels = {"a.a": Label("a.a", "kg", "mass of a"), "a.b": Label("a.b")}
    axis = scatter(results(), ["a.a"], "altitude_error_ft.max_abs", labels, "ft").axes[0]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("mass of a (kg)", "altitude_error_ft.max_abs (ft)")
    assert axis.get_title() == "rank correlation with failure: 0.75"
    failed, succeeded = axis.lines
    assert (len(failed.get_xdata()), len(succeeded.get_xdata())) == (10, 30)
    assert min(failed.get_xdata()) > 0.75 > max(succeeded.get_xdata())
    assert np.array_equal(failed.get_ydata(), 10 * failed.get_xdata())


def texts(legend):
    return [text.get_text() for text in legend.get_texts()]


def test_envelopes_say_what_they_show_at_the_left_and_in_the_first_panel():
    axes = envelopes([FLOWN] * 2, errors(([0, 5], [0, 1], [0, 0])), LABELS, 0.0, 5.0).axes
    labels = [label for label, _ in OVER_TIME.values()]
    assert [axis.get_ylabel() for axis in axes[::2]] == [*labels, "still flying (%)"]
    assert {axis.get_ylabel() for axis in axes[1::2]} == {""}
    assert texts(axes[0].get_legend()) == ["all", "5 to 95 %", "median"]
    assert [axis.get_legend() for axis in axes[1:]] == [None] * 5


def test_histograms_of_values_of_different_size_are_logarithmic_and_one_legend_tells_the_laws():
    values = np.geomspace(1, 1000, 40)
    made = histograms([results(**{HEADLINES[1]: values}), results("y")], JUDGED_BY)
    assert [axis.get_xscale() for axis in made.axes] == ["linear", "log", "linear", "linear"]
    assert texts(made.legends[0]) == ["x", "y"] and [axis.get_legend() for axis in made.axes] == [None] * 4


def test_drivers_of_two_laws_stand_one_below_the_other():
    made = drivers([results(), results("y")], ["a.b", "a.a"], "altitude_error_ft.max_abs", {})
    axes = made.axes
    ends = [(bar.get_y(), bar.get_y() + bar.get_height()) for bar in axes[0].patches]
    assert [end for one in (ends[0], ends[2], ends[1], ends[3]) for end in one] == pytest.approx(
        [-0.4, 0, 0, 0.4, 0.6, 1, 1, 1.4])
    assert axes[0].yaxis_inverted() and texts(made.legends[0]) == ["x", "y"]


@pytest.mark.parametrize("draws,shown,columns", [(4, 4, 6), (15, 12, 12)])
def test_a_scatter_has_a_panel_for_each_of_the_twelve_strongest_drivers(draws, shown, columns):
    names = [f"a.{i}" for i in range(draws)]
    made = results(**{name: np.roll(np.arange(40.0), i) for i, name in enumerate(names)})
    axes = scatter(made, names, "altitude_error_ft.max_abs", {}).axes
    assert len(axes) == columns and sum(axis.get_visible() for axis in axes) == shown
    assert [axis.get_xlabel() for axis in axes[:shown]] == list(made.drivers(names, HEADLINES[0]))[:shown]


def test_what_is_infinite_is_counted_and_not_shown():
    values = np.where(np.arange(40) < 30, 2.0, np.inf)
    axis = histograms([results(**{HEADLINES[0]: values})], JUDGED_BY).axes[0]
    assert axis.get_xlabel() == f"{HEADLINES[0]} (ft); not shown: 10 infinite"
    assert runs_in(axis) == 30 and axis.get_xlim()[0] < 1.9 < 2.1 < axis.get_xlim()[1]
    found = results(**{HEADLINES[0]: values}).summary([], HEADLINES[0], METRICS, "law")["metrics"]
    assert found[HEADLINES[0]] == {"median": 2.0, "p95": 2.0, "max": 2.0, "infinite": 10}
    assert "infinite" not in found[HEADLINES[1]]
