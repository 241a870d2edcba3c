"""Pages of runs: written beside the other results, with everything in them, whatever strangers' texts say."""
import base64
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cosim.cli.app import app
from cosim.errors import UsageError
from cosim.master.aside import aside
from cosim.master.flight import Flight
from cosim.master.wiring import Signal
from cosim.pages.decimate import kept, packed
from cosim.pages.flown import Curve, Flown, Mark, Panel, windows
from cosim.pages.folder import named, results
from cosim.pages.tables import different
from cosim.pages.write import page, plain
from cosim.systems.simulate import simulate
from cosim.vehicle.compare import compare
from cosim.vehicle.look import looked_at, marks
from cosim.vehicle.run import run
from cosim.vehicle.variants import variant
from cosim.vehicle.view import view

ATTACKS = [
    "<script>alert(1)</script>", "</script><script>alert(1)</script>", "<img src=x onerror=alert(1)>",
    "<svg/onload=alert(1)>",
    "\"><b>", "'><b>", "' onmouseover='alert(1)", "\" autofocus onfocus=\"alert(1)", "<!--<script>", "--><b>", "]]><b>",
    "{{data}}{{scripts}}", "</title><b>", "</style><b>", "</textarea><b>", "javascript:alert(1)", "&lt;b&gt;<b>",
    "\u2028\u2029<b>", "<iframe src=//example.org>", "<a href=https://example.org>x</a>", "<\x00b>", "${alert(1)}`<b>",
]


class Seen(HTMLParser):
    """The tags and texts of a page as a browser takes them, but for what our own frame has."""

    def __init__(self, text: str):
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.scripts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs

    def handle_data(self, data):
        if self.lasttag == "script":
            self.scripts.append(data)


def data_in(text: str) -> dict:
    """What the page's script reads."""
    return json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])


def made_up(text: str) -> Flown:
    """A flight with this text wherever a stranger can put one."""
    flight = Flight(np.arange(3.0), np.zeros((3, 1)), [Signal(text, text, text)], False, text, 0.0, 0.0,
                    {text: {text: text}},
                    {text: {"model": text, "file": text, "sha256": text, "generation_tool": text}})
    flight.remarks = [text]
    return Flown(text, flight, {text: text, "scenario": text, "nested": {text: text}},
                 {f"{text} error": Curve(flight.course(text), text, text)}, [Mark(text, text, 0.0, 1.0)])


@pytest.fixture(autouse=True)
def _without_bokeh(request, monkeypatch):
    """A parser takes a second for BokehJS, which is the same in every page."""
    if request.function is test_texts_of_strangers_stay_texts:
        monkeypatch.setattr("cosim.pages.write.library", lambda: "'use strict'")


@pytest.fixture
def harmless() -> Seen:
    return Seen(page("x", [made_up("x"), made_up("x")], [Panel("x", ("x",))], "x", ["x"], [("x", "<p></p>")]))


@pytest.mark.parametrize("attack", ATTACKS, ids=range(len(ATTACKS)))
def test_texts_of_strangers_stay_texts(attack, harmless):
    text = page(attack, [made_up(attack), made_up(attack)], [Panel(attack, (attack,))], attack, [attack],
                [(attack, "<p></p>")])
    seen = Seen(text)
    assert seen.tags == harmless.tags
    assert [name for name, _ in seen.attributes] == [name for name, _ in harmless.attributes]
    assert seen.scripts[1:] == harmless.scripts[1:]  # all but the data
    assert data_in(text)["panels"][0] == {"title": attack, "curves": [attack]}
    checked = Seen(plain(attack, [(attack, "<p></p>", True)], attack))
    assert checked.tags == Seen(plain("x", [("x", "<p></p>", True)], "x")).tags


@pytest.fixture(scope="module")
def flown(tmp_path_factory, native_fmus) -> Path:
    """Folders: two runs of Case 1, one of which departs, and a comparison."""
    place = tmp_path_factory.mktemp("pages")
    run("case1", stop=30, out=place / "good", isolate=True, command="ahv run case1 --stop 30")
    run("case1", preset="printed", stop=30, out=place / "printed")
    compare("hold", [], stop=0.5, out=place / "compared",
            runs=[variant("mine:--preset robust --set controller.k_gamma=0.3")])
    return place


def test_the_page_of_a_run_has_all_and_needs_nothing(flown):
    text = (flown / "good" / "report.html").read_text()
    record = json.loads((flown / "good" / "run.json").read_text())
    assert "report.html" in record["files"] and len(text) < 3_000_000
    own = text.replace(text[text.index("<script>"):text.rindex("</script>")], "")
    assert not re.search(r"https?://|<link(?! rel=\"icon\" href=\"data:,\")|@import|url\(", own)
    assert "default-src 'none'" in text and "ahv run case1 --stop 30" in text
    assert all(fmu["sha256"] in text for fmu in record["fmus"].values())
    data = data_in(text)
    assert set(record["signals"]) | {"V error", "h error"} == set(data["signals"])
    assert {kind["name"] for kind in data["kinds"]} == {"uncertainty of the coefficients", "step of a command"}
    assert any(mark["text"] == "scales of the coefficients: thrust, lift, drag, moment, forces 0.6 to 1.4"
               for mark in data["runs"][0]["marks"])


def test_curves_of_the_page_are_those_of_the_flight(flown):
    curve = data_in((flown / "good" / "report.html").read_text())["runs"][0]["curves"]["plant.h"]
    t, y = (np.frombuffer(base64.b64decode(curve[key]), "<f4").astype(float) for key in "ty")
    (flight, _), = results(flown / "good").values()
    assert np.abs(np.interp(t, flight.time, flight["plant.h"]) - y - curve["base"]).max() < 1e-3
    assert y.min() + curve["base"] == pytest.approx(flight["plant.h"].min()) and len(t) > 1000


def test_a_departure_and_saturation_are_marked(flown):
    found = data_in((flown / "printed" / "report.html").read_text())["runs"][0]["marks"]
    kinds = {mark["kind"]: mark for mark in found}
    assert {"end", "saturation of the elevator", "saturation of the fuel ratio"} <= set(kinds)
    assert kinds["end"]["begin"] == pytest.approx(19.68) and "theta" in kinds["end"]["text"]


def test_marks_of_case_2(native_fmus):
    from cosim.master.fly import fly
    from cosim.vehicle import scenarios
    from cosim.vehicle.closed_loop import closed_loop

    found = marks(fly(closed_loop(scenarios.load("case2"), flavour="native").system, 0.02, 160.0))
    steps = [(mark.begin, mark.text) for mark in found if mark.kind == "step of a command"]
    assert [(pytest.approx(t), text) for t, text in steps] == [
        (0, "velocity command from 7700 to 8033.33 ft/s"), (100, "velocity command from 8033.33 to 8366.66 ft/s"),
        (0, "altitude command from 85000 to 85800 ft"), (100, "altitude command from 85800 to 85000 ft")]
    assert [(mark.begin, mark.end) for mark in found if mark.kind.startswith("uncertainty")] == [
        (pytest.approx(50), pytest.approx(100, abs=0.03)), (pytest.approx(150), pytest.approx(160, abs=0.03))]


def test_several_runs_in_one_page_with_what_differs(flown, tmp_path):
    done = CliRunner().invoke(app, ["view", *map(str, (flown / "good", flown / "printed", flown / "compared")), "--out",
                                    str(tmp_path / "x" / "all.html")])
    assert done.exit_code == 0, done.output
    text = (tmp_path / "x" / "all.html").read_text()
    names = [one["name"] for one in data_in(text)["runs"]]
    assert names == ["good", "printed", "mine", "neural", "neural_ robust"]
    table = text[text.index("What differs"):text.index("<h2>FMUs")]
    assert re.search(r"<td>preset</td><td>calibrated</td><td>printed</td><td>robust</td>", table)
    assert "controller.k_gamma" in table and "plant.mass" not in table


def test_compare_flies_variants_beside_the_neural_law(flown):
    record = json.loads((flown / "compared" / "compare.json").read_text())
    assert list(record["controllers"]) == ["neural", "neural, robust", "mine"]
    mine, robust = (json.loads((flown / "compared" / "runs" / name / "run.json").read_text())
                    for name in ("mine", "neural_ robust"))
    differing = {key for key, value in mine["parameters"]["controller"].items()
                 if value != robust["parameters"]["controller"][key]}
    assert differing == {"k_gamma"} and mine["parameters"]["controller"]["k_gamma"] == 0.3
    assert set(record["files"]) >= {"report.html", "runs/mine/run.json", "runs/mine/signals.parquet"}


@pytest.mark.parametrize("word, sentence", [
    ("mine", "--run mine is not of the form NAME:OPTIONS"),
    (":--preset robust", "is not of the form NAME:OPTIONS"),
    ("mine:--pre robust", "--run mine: unrecognized arguments: --pre robust. A run takes"),
    ("mine:--preset", "--run mine: argument --preset: expected one argument"),
    ("mine:--uncertainty much", "invalid float value: 'much'"),
    ("mine:--set 'x", "no closing quotation"),
    ("mine:--set k=3", "--run mine: --set k=3 is not of the form COMPONENT.VARIABLE=VALUE"),
    ("mine:--preset none", "--run mine: "),
    ("mine:--controller none", "--run mine: --controller none is not known"),
    ("neural:--preset robust", "there are two runs called neural"),
])
def test_a_variant_that_cannot_be_flown_gets_a_sentence(native_fmus, tmp_path, word, sentence):
    with pytest.raises(UsageError, match=re.escape(sentence)):
        compare("hold", [], stop=0.1, out=tmp_path / "out", runs=[variant(word)])
    assert not (tmp_path / "out").exists()


def test_a_simulation_has_a_page_of_its_units(native_fmus, tmp_path):
    simulate(native_fmus["AhvPlant"], 0.1, 1.0, None, tmp_path / "out", command="ahv simulate AhvPlant.fmu")
    data = data_in((tmp_path / "out" / "report.html").read_text())
    units = [{data["signals"][name]["unit"] for name in panel["curves"]} for panel in data["panels"]]
    assert len(units) > 3 and {"ft/s"} in units and all(len(one) == 1 for one in units)
    assert 0 < len(data["chosen"]) <= 48


def test_a_check_as_a_page(native_fmus, tmp_path):
    done = CliRunner().invoke(app, ["check", str(native_fmus["AhvScenario"]), "--no-dynamic", "--out",
                                    str(tmp_path / "c.html")])
    assert done.exit_code == 0, done.output
    assert "Check of AhvScenario.fmu" in (tmp_path / "c.html").read_text()


@pytest.mark.parametrize("make, sentence", [
    (lambda path: path / "none", "There is no folder"),
    (lambda path: path, "has no results of ahv; what can be seen are folders of ahv run, simulate and compare"),
    (lambda path: broken(path, b"PAR1"), "signals.parquet cannot be read"),
    (lambda path: broken(path, None), "signals.parquet cannot be read: there is no such file"),
    (lambda path: killed(path), "has rows of a flight that was killed: `ahv recover "),
])
def test_folders_without_flights_are_refused(tmp_path, make, sentence):
    with pytest.raises(UsageError, match=sentence):
        view([make(tmp_path)], tmp_path / "view.html")
    assert not (tmp_path / "view.html").exists()


def broken(path: Path, signals: bytes | None) -> Path:
    (path / "run.json").write_text('{"kind": "run", "controller": "x"}')
    if signals is not None:
        (path / "signals.parquet").write_bytes(signals)
    return path


def killed(path: Path) -> Path:
    (path / ".ahv").mkdir()
    (path / ".ahv" / "kind.json").write_text('{"kind": "run"}')
    (path / ".ahv" / "rows.arrows").touch()
    return path


def test_names_tell_folders_apart(tmp_path):
    assert named([tmp_path / "a", tmp_path / "b"]) == ["a", "b"]
    assert named([tmp_path / "a" / "x", tmp_path / "b" / "x"]) == ["a/x", "b/x"]
    assert named([tmp_path / "a", tmp_path / "a"]) == ["a (1)", "a (2)"]


def test_decimation_keeps_ends_and_extremes():
    values = np.sin(np.arange(100_000) / 7000)
    values[54_321], values[54_400] = 9.0, -9.0
    rows = kept(values, 1000)
    assert len(rows) < 1100 and {0, 54_321, 54_400, 99_999} <= set(rows.tolist())
    assert np.all(np.diff(rows) > 0)
    steps = np.repeat([1.0, 2.0, 1.0], 1000)
    assert kept(steps, 6000).tolist() == [0, 999, 1000, 1999, 2000, 2999]
    assert kept(np.array([1.0]), 100).tolist() == [0] and kept(np.full(5, np.nan), 100).tolist() == [0, 1, 2, 3, 4]
    strange = packed(np.arange(3.0), np.array([np.nan, np.inf, 1e300]), 100)
    assert strange["base"] == 1e300 and json.dumps(strange, allow_nan=False)


def test_a_line_between_kept_rows_is_near_and_what_is_not_finite_stays_so():
    time = np.arange(30_000) * 0.01
    values = np.exp(-time) * np.sin(7 * time) + 0.01 * np.sin(time / 20)  # of which a bin has a fifth of a second
    rows = kept(values, 2000)
    assert len(rows) <= 2000
    assert np.abs(np.interp(time, time[rows], values[rows]) - values).max() < 2e-3 * np.ptp(values)
    values[[20_000, 20_001]] = np.nan
    assert {19_999, 20_000, 20_001, 20_002} <= set(kept(values, 2000).tolist())
    falling = packed(time, 1e6 * np.exp(-time), 2000)
    y = falling["base"] + np.frombuffer(base64.b64decode(falling["y"]), "<f4").astype(float)
    assert y[-1] == pytest.approx(1e6 * np.exp(-time[-1]), abs=1e-6)


def test_steps_of_commands_are_marked_in_few_rows_and_steps_by_hand_differ():
    command = np.where(np.arange(11) < 5, 7700.0, 7900.0)
    flight = Flight(np.arange(11.0), command[:, None], [Signal("scenario.V_command", "ft/s", "")], True, "", 0.0, 0.0,
                    {}, {})
    assert [mark.begin for mark in marks(flight)] == [5.0]
    for wrong in (5, [3], {"a": 1}, [{"time": "x", "input": "plant.scale_drag", "value": 0.1}], [{"time": 1.0}]):
        with pytest.raises(UsageError, match="no list of steps"):
            looked_at("a", flight, {"live": wrong})
    made = [{"time": 1.0, "input": "plant.scale_drag", "value": 0.1}]
    assert "steps made by hand" in different([Flown("a", flight, {}), Flown("b", flight, {"live": made})])


def test_a_name_with_two_units_is_two_signals():
    def flown(name: str, unit: str) -> Flown:
        flight = Flight(np.arange(3.0), np.ones((3, 1)), [Signal("a.y", unit, "")], True, "", 0.0, 0.0, {}, {})
        return Flown(name, flight, {})

    data = data_in(page("x", [flown("first", "ft"), flown("second", "m"), flown("third", "ft")]))
    assert {name: said["unit"] for name, said in data["signals"].items()} == {"a.y": "ft", "a.y in m": "m"}
    assert [list(run["curves"]) for run in data["runs"]] == [["a.y"], ["a.y in m"], ["a.y"]]


@pytest.mark.parametrize("largest", [1e300, 1.7e308, 1e39, 1e-42, 1e-300, 5e-324])
def test_values_beyond_32_bits_keep_their_digits(largest):
    values = np.array([-largest, 0.0, largest / 3, np.nan, largest])
    curve = packed(np.arange(5.0), values, 100)
    y, scale = np.frombuffer(base64.b64decode(curve["y"]), "<f4").astype(float), curve["scale"]
    assert scale * (curve["base"] / scale + y) == pytest.approx(values, rel=1e-6, abs=1e-7 * largest, nan_ok=True)
    assert "scale" not in packed(np.arange(2.0), np.array([1e15, 1e15 + 1]), 100)


def test_what_a_page_leaves_out_is_said(monkeypatch):
    def said(count: int, flights: int) -> str:
        columns = [Signal(f"s{i}", "", "") for i in range(count)]
        flight = Flight(np.arange(3.0), np.zeros((3, count)), columns, False, "x", 0.0, 0.0, {}, {})
        text = page("x", [Flown(f"flight {i}", flight, {}) for i in range(flights)])
        return re.sub(r"<[^>]*>", "", text[text.index("<header>"):text.index("</header>")])

    monkeypatch.setattr("cosim.pages.write.library", lambda: "")
    monkeypatch.setattr("cosim.pages.write.SIGNALS", 5)
    assert "No signals were recorded." in said(0, 1) and "signals" not in said(5, 1)
    assert "The page has 5 of the 6 signals." in said(6, 2)
    assert "4 of 4 flights ended early" in said(1, 4) and "ended early" in said(1, 3) and "of 3" not in said(1, 3)


def test_windows_begin_with_the_step_in_which_they_hold():
    time = np.arange(1001) / 10
    holds = np.zeros(1001)
    holds[[11, 12, 13, 14, 15, 500]] = 1
    assert [(w.begin, w.end) for w in windows("k", "t", time, holds)] == [(1.0, 1.5), (49.9, 50.0)]
    assert windows("k", "t", time, np.zeros(1001)) == []
    chatters = np.zeros(1001)
    chatters[[100, 101, 103]] = 1  # a pause that nobody would see
    assert [(w.text, w.begin, w.end) for w in windows("k", "t", time, chatters)] == [
        ("t, with pauses", time[99], time[103])]


def fill(place: Path, word: str) -> None:
    (place / "below").mkdir(exist_ok=True)
    (place / "below" / "word").write_text(word)


def fail(place: Path, word: str) -> None:
    if "ahv-temporary" in str(place):
        raise RuntimeError
    (place / "here").write_text(word)


@pytest.mark.parametrize("wanted", [False, True])
def test_work_that_is_done_aside_is_done_in_any_case(tmp_path, wanted):
    with aside(wanted, lambda: None, fill, fail) as process:
        process.start("x" * 200_000)(tmp_path)
    assert {path.name for path in tmp_path.rglob("*") if path.is_file()} == {"word", "here"}


def test_a_process_aside_that_is_not_wanted_any_more_is_ended(tmp_path):
    with pytest.raises(UsageError), aside(True, lambda: None, fill):
        raise UsageError("Something else.")
