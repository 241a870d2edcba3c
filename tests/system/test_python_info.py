"""`cosim.info` and `cosim.check`, and what a notebook shows of them and of flights: strangers' texts are escaped."""
import json
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import cosim
from cosim.conformance.report import Finding, NotTested
from cosim.master.flight_page import MOST_ROWS
from cosim.master.wiring import Signal

HOSTILE = "<script>alert('x')</script>"
FMI_3 = """<?xml version="1.0"?>
<fmiModelDescription fmiVersion="3.0" modelName="three" instantiationToken="t" license="BSD-2-Clause" author="A. Author"
  copyright="(c) A. Author" generationTool="hand" generationDateAndTime="2026-01-02T03:04:05Z" version="7">
  <ModelExchange modelIdentifier="three"/><CoSimulation modelIdentifier="three" maxOutputDerivativeOrder="2"/>
  <TypeDefinitions><Float64Type name="angle" unit="rad" displayUnit="deg" min="-1"/></TypeDefinitions>
  <DefaultExperiment stopTime="2.5" tolerance="1e-4"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="phi" valueReference="1" causality="input" declaredType="angle" start="0.5" max="INF"/>
    <Int32 name="n" valueReference="2" causality="structuralParameter" variability="fixed" start="3"/>
    <Float64 name="row" valueReference="3" causality="parameter" variability="fixed" start="1 2 3"/>
    <Boolean name="on" valueReference="4" causality="parameter" variability="fixed" start="true"/>
    <String name="label" valueReference="5" causality="parameter" variability="fixed"><Start value="12"/></String>
  </ModelVariables><ModelStructure/>
</fmiModelDescription>"""


def written(path, description, *others):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        for name in others:
            archive.writestr(name, "")
    return path


class Page(HTMLParser):
    """The elements and texts of some HTML."""

    def __init__(self, html):
        super().__init__()
        self.elements, self.texts = set(), []
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        assert not attrs
        self.elements.add(tag)

    def handle_data(self, data):
        self.texts.append(data)


def safe(shown):
    """The texts of what `shown` looks like in a notebook, which has no elements but those of tables."""
    page = Page(shown._repr_html_())
    assert page.elements <= {"p", "b", "table", "thead", "tbody", "tr", "th", "td"}
    return page.texts


# --- info -----------------------------------------------------------------------------------------------

def test_info_is_what_the_fmu_declares(native_fmus):
    about = cosim.info(str(native_fmus["AhvPlant"]))
    assert (about.name, about.fmi_version, about.kinds) == (
        "AhvPlant", "2.0", ("co-simulation", "model exchange"))
    assert "linux64" in about.platforms and about.presets == ("decoupled", "estimated-coupling",
                                                              "estimated-coupling-energy")
    assert about.default_experiment == {"start": 0, "stop": 100, "step": 0.01}
    assert about.capabilities["canGetAndSetFMUstate"] is True
    elevator, start, theta = about["elevator"], about["V_start"], about["theta"]
    assert (elevator.causality, elevator.unit, elevator.display_unit) == ("input", "rad", "deg")
    assert (start.start, start.min, start.max, start.settable) == (7700.0, 5000.0, 15000.0, True)
    assert theta.start is None and not theta.settable and theta.description == "pitch angle"
    assert about["start_at_trim"].start is True


def test_info_as_text_has_one_line_for_each_variable(native_fmus):
    about = cosim.info(native_fmus["AhvPlant"])
    lines = str(about).splitlines()
    for v in about.variables:
        line, = (line for line in lines if line.split()[:1] == [v.name])
        assert v.unit in line and line.endswith(v.description)
    assert f"  file: {native_fmus['AhvPlant']}" in lines
    assert lines[0] == "AhvPlant" and any(line.startswith("parameter (") for line in lines)
    assert safe(about)[0] == "AhvPlant" and "pitch angle" in safe(about)


def test_info_as_a_dict_is_json(native_fmus):
    about = cosim.info(native_fmus["AhvController"])
    found = json.loads(json.dumps(about.to_dict(), allow_nan=False))
    assert found["path"] == str(native_fmus["AhvController"]) and found["name"] == "AhvController"
    assert len(found["variables"]) == len(about.variables)
    assert found["variables"][0] == {"name": "V", "causality": "input", "variability": "continuous", "type": "Real",
                                     "unit": "ft/s", "display_unit": "", "start": 7700.0, "min": 4000.0, "max": 16000.0,
                                     "settable": True, "description": "measured velocity"}


def test_info_reads_other_fmi_versions(tmp_path):
    about = cosim.info(written(tmp_path / "three.fmu", FMI_3, "binaries/x86_64-linux/three.so",
                               "binaries/aarch64-darwin/three.dylib", "resources/presets/mild.ssv", "resources/a.ssv"))
    assert (about.fmi_version, about.kinds) == ("3.0", ("co-simulation", "model exchange"))
    assert (about.license, about.author, about.version) == ("BSD-2-Clause", "A. Author", "7")
    assert about.platforms == ("aarch64-darwin", "x86_64-linux") and about.presets == ("mild",)
    assert about.default_experiment == {"stop": 2.5, "tolerance": 1e-4}
    assert about.capabilities == {"maxOutputDerivativeOrder": 2}
    phi = about["phi"]  # what the type says where the variable is silent
    assert (phi.unit, phi.display_unit, phi.min, phi.max, phi.start) == ("rad", "deg", -1.0, None, 0.5)
    starts = [about[name].start for name in ("time", "n", "row", "on", "label")]
    assert starts == [None, 3, "1 2 3", True, "12"]
    assert "license: BSD-2-Clause" in str(about) and "made by: hand 2026-01-02T03:04:05Z" in str(about)


@pytest.mark.parametrize("text,value", [("true", True), ("1", True), (" 1 ", True), ("false", False), ("0", False),
                                        ("yes", "yes")])
def test_info_reads_truths_as_xml_writes_them(tmp_path, text, value):
    about = cosim.info(written(tmp_path / "three.fmu", FMI_3.replace('start="true"', f'start="{text}"')))
    assert about["on"].start is value or about["on"].start == value == text


@pytest.mark.parametrize("content,sentence", [
    (None, "cannot be opened: there is no file"), (b"x", "is not a zip file"),
    ("<nothing/>", "cannot be read as an FMU"), ("not XML", "cannot be read as an FMU")])
def test_info_refuses_what_is_no_fmu_in_one_sentence(tmp_path, content, sentence):
    path = tmp_path / "some.fmu"
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif content:
        written(path, content)
    with pytest.raises(cosim.UsageError, match=sentence) as caught:
        cosim.info(path)
    assert "\n" not in str(caught.value)


def test_info_says_which_variable_is_not_there(native_fmus):
    with pytest.raises(cosim.UsageError, match=r"AhvPlant.fmu has no variable maas; did you mean mass\?"):
        cosim.info(native_fmus["AhvPlant"])["maas"]


# --- check ----------------------------------------------------------------------------------------------

def test_check_says_whether_an_fmu_passes(native_fmus, tmp_path):
    report = cosim.check(str(native_fmus["AhvPlant"]), dynamic=False)
    assert isinstance(report, cosim.Report) and report.passed
    assert {finding.rule.partition(".")[0] for finding in report.findings} <= {"naive"}
    assert any("AhvPlant.fmu: passed, 0 errors, 0 warnings, " in text for text in safe(report))
    assert report.verdict in safe(report)
    broken = cosim.check(written(tmp_path / "broken.fmu", "<nothing/>"))
    assert not broken.passed and broken.findings
    assert any("broken.fmu: failed, " in text for text in safe(broken))


@pytest.mark.parametrize("arguments,sentence", [
    (("missing.fmu",), "There is no file missing.fmu"), ((3,), "3 is not the path of a file"),
    ((__file__, True, "long"), "time_limit = 'long' is not allowed")])
def test_check_refuses_wrong_arguments(arguments, sentence):
    with pytest.raises(cosim.UsageError, match=sentence):
        cosim.check(*arguments)


# --- strangers' texts -----------------------------------------------------------------------------------

def test_a_report_shows_strangers_texts_and_obeys_none():
    report = cosim.Report(Path(f"{HOSTILE}.fmu"))
    report.findings.append(Finding("xml.schema", "2.2", "error", HOSTILE, f"&amp;{HOSTILE}", "an <expected> text"))
    report.not_tested.append(NotTested(HOSTILE, "why not"))
    texts = safe(report)
    assert texts.count(HOSTILE) == 2 and f"&amp;{HOSTILE}" in texts and "an <expected> text" in texts


def test_an_info_shows_strangers_texts_and_obeys_none(tmp_path):
    escaped = HOSTILE.replace("<", "&lt;").replace(">", "&gt;")
    about = cosim.info(written(tmp_path / "three.fmu", FMI_3.replace("hand", escaped).replace('"label"', f'"{escaped}"')
                               .replace('modelName="three"', 'modelName="a&#10;b&#x9b;c"')))
    texts = safe(about)
    assert HOSTILE in texts and any(HOSTILE in text for text in texts if "2026" in text)
    assert all(character.isprintable() or character == "\n" for character in str(about))
    assert str(about).splitlines()[0] == r"a\nb\x9bc"


def made_up(names, **changed):
    """A flight of two rows, as strangers' FMUs may name its signals."""
    known = {"time": np.array([0.0, 1.0]), "signals": np.array([[1.5] * len(names), [-2.5] * len(names)]),
             "columns": [Signal(name, HOSTILE, HOSTILE) for name in names], "finished": False, "message": HOSTILE,
             "startup_s": 0.0, "wall_s": 1.0, "parameters": {}, "ticks": 1,
             "fmus": {"a": {"file": HOSTILE, "model": HOSTILE, "guid": "", "sha256": "", "generation_tool": HOSTILE}}}
    return cosim.Flight(**{**known, **changed})


def test_a_flight_shows_strangers_texts_and_obeys_none():
    texts = safe(made_up([HOSTILE, "$x_{y"]))
    assert texts.count(HOSTILE) >= 7 and {"1.5", "-2.5"} <= {*texts}
    assert any(f"ended early: {HOSTILE}" in text for text in texts)
    drawn = made_up([HOSTILE, "$x_{y$"]).plot(HOSTILE, "$x_{y$")._repr_png_()  # no formula
    assert drawn.startswith(b"\x89PNG")


def test_a_flight_of_many_signals_shows_some_and_says_how_many_more():
    texts = safe(made_up([f"a.x{i}" for i in range(MOST_ROWS + 5)], finished=True, message=""))
    assert "and 5 more signals" in texts and "a.x0" in texts and f"a.x{MOST_ROWS}" not in texts


def test_a_flight_shows_what_happened(native_fmus):
    flight = cosim.fly(cosim.System([cosim.Component("plant", native_fmus["AhvPlant"])]), step=0.1, stop=1,
                       record=["plant.h"])
    assert repr(flight) == "<Flight of plant to 1 s in 10 steps, finished. 11 rows of 1 signal.>"
    texts = safe(flight)
    assert {"plant", "AhvPlant", "plant.h", "ft", "altitude", "85000"} <= {*texts}
