"""What a grid shows: figures and pictures over the swept variables."""
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pytest
from matplotlib.colors import LogNorm

from cosim.campaign.distributions import Choice, Uniform
from cosim.campaign.grid import borders, colours, extremes, pictures, places, shown_metrics, table_rows
from cosim.campaign.labels import Label
from cosim.campaign.sampling import Draw
from cosim.campaign.statistics import Results

GAIN = Draw("law.gain", ("law.gain",), Uniform(distribution="uniform", low=1, high=3, points=3))
MASS = Draw("plant.mass", ("plant.mass",), Choice(distribution="choice", values=[300, 280]))
KIND = Draw("plant.kind", ("plant.kind",), Choice(distribution="choice", values=["a$", "b"]))
NAMES = ("first", "second")


def plan(*draws, success=("error < 5",)):
    """A plan of two variants with the metrics error and other."""
    figure = SimpleNamespace(unit="ft", headline="")
    return SimpleNamespace(draws=dict.fromkeys(NAMES, draws), laws=list(NAMES), worst_by="other",
                           metrics={"error": figure, "other": figure},
                           labels={d.name: Label(d.name, "s") for d in draws},
                           campaign=SimpleNamespace(metrics={}, success=dict(enumerate(success))))


def results(values, missing=()):
    """Rows of both variants, in which the metric error has `values`; runs in `missing` were not judged."""
    runs = range(len(values))
    status = ["error" if k in missing else "finished" for k in runs]
    columns = {"error": values, "other": [1.0] * len(values), "success": [x < 5 for x in values]}
    table = pa.table({"run": list(runs), "variant": [NAMES[0]] * len(values), "status": status, **columns})
    other = table.set_column(1, "variant", [[NAMES[1]] * len(values)])
    return [Results.of(name, pa.concat_tables([table, other]), "variant") for name in NAMES]


def panels(figure):
    """The axes of a figure with something on them."""
    return [axis for axis in figure.axes if axis.get_visible() and axis.get_label() != "<colorbar>"]


def test_the_least_and_the_greatest_value_are_said_with_their_places():
    made, rows = plan(GAIN, MASS), results([1.0, 2.0, np.inf, 9.0, 0.5, 7.0], missing=[3])
    found = {r.law: extremes(made, r) for r in rows}
    assert found["first"]["error"] == {
        "least": {"value": 0.5, "run": 4, "at": {"law.gain": 3.0, "plant.mass": 300.0}},
        "greatest": {"value": 7.0, "run": 5, "at": {"law.gain": 3.0, "plant.mass": 280.0}}}
    assert table_rows(made, found)[0] == ["first", "error", "0.5 ft at law.gain = 3, plant.mass = 300",
                                          "7 ft at law.gain = 3, plant.mass = 280"]


def test_one_variable_is_drawn_as_lines_in_its_order_with_failures_crossed():
    (name, draw), = pictures(plan(MASS), results([7.0, 2.0])).items()
    axis, = panels(draw())
    lines = axis.get_lines()
    assert name == "sweep_error" and axis.get_xlabel() == "plant.mass (s)" and axis.get_ylabel() == "error (ft)"
    assert [lines[0].get_xdata().tolist(), lines[0].get_ydata().tolist()] == [[280.0, 300.0], [2.0, 7.0]]
    assert lines[1].get_xdata().tolist() == [300.0]
    assert [text.get_text() for text in axis.get_legend().get_texts()] == ["first", "no success", "second"]


def test_two_variables_are_drawn_as_a_map_for_each_variant():
    draw = pictures(plan(GAIN, MASS), results([1.0, 2.0, 3.0, 4.0, 50.0, 7.0], missing=[1]))["sweep_error"]
    axes = panels(draw())
    assert [axis.get_title() for axis in axes] == ["first", "second"]
    mesh = axes[0].collections[0]
    assert mesh.get_array().tolist() == [[None, 4.0, 7.0], [1.0, 3.0, 50.0]]  # from the bottom: 280, 300
    assert (mesh.norm.vmin, mesh.norm.vmax, axes[1].collections[0].colorbar.extend) == (1.0, 4.0, "max")
    assert {text.get_text() for text in axes[0].texts} == {"1.00", "3.00", "4.00", "50.0\n×", "7.00\n×"}


def test_three_variables_are_drawn_as_a_map_for_each_value_of_the_third():
    made = plan(GAIN, MASS, KIND)
    figure = pictures(made, results([float(k) for k in range(12)])[:1])["sweep_error"]()
    assert [axis.get_title() for axis in panels(figure)] == ["plant.kind = a\\$", "plant.kind = b"]
    assert panels(figure)[1].collections[0].get_array().tolist() == [[3.0, 7.0, 11.0], [1.0, 5.0, 9.0]]
    figure.canvas.draw()  # words with a dollar sign are no formulas


def test_a_value_that_does_not_vary_needs_no_axis():
    one = Draw("a.x", ("a.x",), Choice(distribution="choice", values=[2]))
    axis, = panels(pictures(plan(one, MASS), results([1.0, 2.0]))["sweep_error"]())
    assert axis.get_xlabel() == "plant.mass (s)"


def test_metrics_of_the_file_and_of_its_criteria_are_drawn_else_the_one_that_ranks():
    made = plan(GAIN, success=["other < 1 and error < 3"])
    made.campaign.metrics["error"] = "max(plant.x)"
    assert shown_metrics(made) == ["error", "other"]
    assert shown_metrics(plan(GAIN, success=[])) == ["other"]


@pytest.mark.parametrize("values,success,low,high,beyond", [
    ([1, 2, 900], [1, 1, 0], 1, 2, "max"), ([0, 1, 2, 9], [0, 1, 1, 0], 1, 2, "both"),
    ([1, 5], [0, 0], 1, 5, "neither"), ([0, 3, 9], [0, 1, 0], 0, 9, "neither"), ([np.nan], [np.nan], 0, 1, "neither"),
])
def test_the_scale_is_that_of_the_successes(values, success, low, high, beyond):
    scale, end = colours(np.array(values, float), np.array(success, float))
    assert (scale.vmin, scale.vmax, end) == (low, high, beyond) and not isinstance(scale, LogNorm)


def test_cells_lie_about_their_points():
    assert borders(np.array([1.0, 2.0, 4.0])).tolist() == [0.5, 1.5, 3.0, 5.0]
    assert borders(np.array([3.0])).tolist() == [2.5, 3.5]
    assert places([300.0, 280.0]).tolist() == [300, 280] and places([True, False]).tolist() == [0, 1]
