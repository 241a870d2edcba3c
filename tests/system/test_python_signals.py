"""Signals of a flight: arrays with units, tables, pictures."""
import pickle
import sys

import numpy as np
import pyarrow.parquet
import pytest

import cosim
from cosim.master.results import write as write_results


@pytest.fixture(scope="module")
def loop(native_fmus):
    plant, controller = (cosim.Component(name, native_fmus[model]) for name, model in (
        ("plant", "AhvPlant"), ("controller", "AhvController")))
    links = [cosim.Connection(f"{a}.{name}", f"{b}.{name}") for a, b, names in (
        ("plant", "controller", ("V", "h", "gamma", "theta", "Q")),
        ("controller", "plant", ("fuel_ratio", "elevator"))) for name in names]
    return cosim.System([plant, controller.with_values({"h_command": 85400.0})], links)


@pytest.fixture(scope="module")
def flight(loop):
    return cosim.fly(loop, step=0.01, stop=2)


# --- signals --------------------------------------------------------------------------------------------

def test_a_signal_is_an_array_with_its_unit(flight):
    theta = flight["plant.theta"]
    assert isinstance(theta, np.ndarray) and theta.shape == flight.time.shape == (201,)
    assert (theta.name, theta.unit, theta.display_unit) == ("plant.theta", "rad", "deg")
    assert theta.description == "pitch angle"
    assert np.shares_memory(theta, flight.signals)
    assert (flight["plant.V"].unit, flight["plant.V"].display_unit) == ("ft/s", "ft/s")


def test_a_signal_is_shown_in_its_display_unit(flight):
    shown = flight["plant.theta"].displayed
    assert np.allclose(shown, np.degrees(np.asarray(flight["plant.theta"])), rtol=1e-14) and shown.unit == "deg"
    assert np.array_equal(flight["plant.V"].displayed, flight["plant.V"])


def test_slices_keep_the_unit_and_arithmetic_is_plain(flight):
    h = flight["plant.h"]
    assert h[10:20].unit == "ft" and h[h > 0].unit == "ft"
    for result in (h - 85000.0, h * h, abs(h), np.diff(h), np.degrees(h), -h):
        assert type(result) is np.ndarray
    for number in (h.max(), h.mean(), np.abs(h - h).max(), h[0], h.sum(), h.std()):
        assert isinstance(number, float)
    assert h.max() == flight.signals[:, list(flight).index("plant.h")].max()


def test_a_signal_survives_pickling_and_copying(flight):
    for twin in (pickle.loads(pickle.dumps(flight["plant.theta"])), flight["plant.theta"].copy()):
        assert np.array_equal(twin, flight["plant.theta"]) and twin.display_unit == "deg"


def test_a_name_that_is_none_suggests_the_nearest(flight):
    with pytest.raises(cosim.UsageError, match=r"^This flight has no signal plant.hh; did you mean plant.h\?$"):
        flight["plant.hh"]
    with pytest.raises(KeyError):
        flight["plant.hh"]
    assert "plant.h" in flight and "plant.hh" not in flight and 0 not in flight
    assert list(flight) == [column.name for column in flight.columns]


# --- tables and pictures --------------------------------------------------------------------------------

def test_the_arrow_table_is_what_a_run_writes(flight, tmp_path):
    write_results(tmp_path, "run", flight, {})
    assert flight.to_arrow().equals(pyarrow.parquet.read_table(tmp_path / "signals.parquet"), check_metadata=True)


def test_the_frame_has_time_as_index_and_units(flight):
    frame = flight.to_pandas()
    assert frame.index.name == "time" and list(frame.columns) == list(flight)
    assert np.array_equal(frame.index, flight.time) and np.array_equal(frame["plant.h"], flight["plant.h"])
    assert frame.attrs["units"]["plant.theta"] == "rad"


def test_without_pandas_one_sentence_says_so(flight, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(cosim.UsageError, match=r"to_pandas needs pandas, which is not installed: pip install pandas."):
        flight.to_pandas()


def test_a_picture_has_a_panel_for_each_unit_and_for_differences(flight):
    figure = flight.plot("plant.h", "plant.theta", "controller.h_reference", "plant.h - controller.h_reference",
                         "plant.theta - plant.gamma", "controller.fuel_ratio")
    axes = figure.axes
    assert [axis.get_ylabel() for axis in axes] == ["ft", "deg", "ft", "deg", "1"]
    assert axes[-1].get_xlabel() == "time (s)"
    assert [line.get_label() for line in axes[0].lines] == ["plant.h", "controller.h_reference"]
    drawn = [np.asarray(axis.lines[0].get_ydata()) for axis in axes]
    assert np.allclose(drawn[1], np.degrees(np.asarray(flight["plant.theta"])))
    assert np.array_equal(drawn[2], flight["plant.h"] - flight["controller.h_reference"])
    assert np.allclose(drawn[3], np.degrees(flight["plant.theta"] - flight["plant.gamma"]))
    assert figure._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("names,sentence", [
    ((), "Name at least one signal"), (("plant.hh",), "did you mean plant.h"),
    (("plant.h - plant.hh",), "no signal plant.hh"),
    (("plant.h - plant.V",), "cannot be drawn: plant.h is in ft, plant.V in ft/s")])
def test_what_cannot_be_drawn_is_refused(flight, names, sentence):
    with pytest.raises(cosim.UsageError, match=sentence):
        flight.plot(*names)
