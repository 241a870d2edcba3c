"""What the builder writes of a model: its description, presets, page, icon and table in C, each read back."""
import re
import struct
import xml.etree.ElementTree as ET
import zlib
from math import pi

import pytest
from test_model_mistakes import LEVEL, MODEL, RATE, tank

from fmus import documentation, floats, symbols
from fmus.description import Flavour, model_description, parameter_set
from fmus.interface import internal_steps, variables
from fmus.native_code import generated_sources
from fmus.trace import trace_model

ANGLE = '("angle", "output", "rad", None, -1.0, 1.0, 0.5, "of <the> float")'
TURN = '("turn", "calculatedParameter", "rad/s frequency", None, None, None, None, "of the screw")'
TILT = '("tilt", "parameter", "rad", 0.5, None, 1.5, None, "of the tank")'
LOCKED = '("locked", "parameter", "", False, None, None, None, "no flow")'
RESULTS = '"level": x[0], "full": x[0] > 1.0'


@pytest.fixture(scope="module")
def model():
    return tank((LEVEL, f"{LEVEL},\n    {ANGLE},\n    {TURN}"), (RATE, f"{RATE},\n    {TILT},\n    {LOCKED}"),
                (RESULTS, f'{RESULTS}, "angle": p.tilt * u.flow, "turn": p.rate'),
                ('{"slow": {"rate": 1.0}}', '{"slow": {"rate": 1.0, "tilt": 0.25, "locked": True}}'))


@pytest.fixture(scope="module")
def trace(model):
    return trace_model(model)


@pytest.fixture(scope="module")
def root(model, trace):
    flavour = Flavour({"canGetAndSetFMUstate": "true"}, ["all.c"])
    return ET.fromstring(model_description(model, trace, flavour, "{guid}", "1.2", "a tool"))


def variable(root, name):
    found, = root.findall(f"ModelVariables/ScalarVariable[@name='{name}']")
    return found


def test_every_variable_has_its_kind(root):
    found = {v.get("name"): (v.get("causality"), v.get("variability"), v.get("initial"), v[0].tag)
             for v in root.findall("ModelVariables/ScalarVariable")}
    assert found == {
        "flow": ("input", "continuous", None, "Real"), "open": ("input", "discrete", None, "Boolean"),
        "level": ("output", "continuous", "calculated", "Real"),
        "angle": ("output", "continuous", "calculated", "Real"),
        "turn": ("calculatedParameter", "fixed", "calculated", "Real"),
        "full": ("output", "discrete", "calculated", "Boolean"), "rate": ("parameter", "fixed", "exact", "Real"),
        "tilt": ("parameter", "fixed", "exact", "Real"), "locked": ("parameter", "fixed", "exact", "Boolean"),
        "internal_step": ("parameter", "fixed", "exact", "Real")}


def test_a_real_may_be_discrete():
    model = tank(('"full", "output", ""', '"full", "output", "1 discrete"'))
    root = ET.fromstring(model_description(model, trace_model(model), Flavour({}), "", "", ""))
    full = variable(root, "full")
    assert (full.get("variability"), full[0].tag, full[0].attrib) == ("discrete", "Real", {"unit": "1"})


def test_limits_and_units_are_those_of_the_table(root):
    assert variable(root, "angle")[0].attrib == {"unit": "rad", "displayUnit": "deg", "min": "-1.0", "max": "1.0",
                                                 "nominal": "0.5"}
    assert variable(root, "turn")[0].attrib == {"unit": "rad/s"}  # a frequency is shown as it is
    assert variable(root, "rate")[0].attrib == {"unit": "1/s", "min": "0.0", "max": "5.0", "start": "2.0"}
    assert variable(root, "open")[0].attrib == {"start": "true"} and variable(root, "full")[0].attrib == {}
    assert variable(root, "locked")[0].attrib == {"start": "false"}
    units = {unit.get("name"): unit for unit in root.findall("UnitDefinitions/Unit")}
    assert sorted(units) == ["1", "1/s", "rad", "rad/s", "s"]
    shown = units["rad"].find("DisplayUnit")
    assert shown.get("name") == "deg" and float(shown.get("factor")) == pytest.approx(180 / pi)
    assert units["rad/s"].find("DisplayUnit") is None and units["1/s"].find("BaseUnit").attrib == {"s": "-1"}


def test_what_depends_on_what(root):
    order = [v.get("name") for v in root.findall("ModelVariables/ScalarVariable")]

    def known(kind):
        return {order[int(u.get("index")) - 1]: [order[int(i) - 1] for i in u.get("dependencies").split()]
                for u in root.findall(f"ModelStructure/{kind}/Unknown")}

    assert known("Outputs") == {"level": [], "angle": ["flow"], "full": []}
    assert known("InitialUnknowns") == {"level": ["flow", "rate"], "angle": ["flow", "tilt"], "turn": ["rate"],
                                        "full": ["flow", "rate"]}


def test_the_head_names_model_flavour_and_experiment(root):
    interface = root.find("CoSimulation")
    names = ("modelName", "guid", "version", "generationTool")
    assert [root.get(name) for name in names] == ["Tank", "{guid}", "1.2", "a tool"]
    assert interface.get("modelIdentifier") == "Tank" and interface.get("canGetAndSetFMUstate") == "true"
    assert [file.get("name") for file in interface.findall("SourceFiles/File")] == ["all.c"]
    assert root.find("DefaultExperiment").attrib == {"startTime": "0", "stopTime": "100", "stepSize": "0.01"}


def test_a_flavour_without_sources_names_none(model, trace):
    root = ET.fromstring(model_description(model, trace, Flavour({}), "", "", ""))
    assert root.find("CoSimulation/SourceFiles") is None


def test_a_preset_is_a_parameter_set(model):
    root = ET.fromstring(parameter_set("slow", model.PRESETS["slow"]))
    found = {p.get("name"): (p[0].tag.rpartition("}")[2], p[0].get("value")) for p in root[0]}
    assert root.get("name") == "slow"
    assert found == {"rate": ("Real", "1.0"), "tilt": ("Real", "0.25"), "locked": ("Boolean", "true")}


def test_the_page_shows_values_as_people_read_them(model, trace, tmp_path):
    (tmp_path / "tank.py").write_text(f'"""A <tank>."""\n{MODEL}')
    model.__file__ = str(tmp_path / "tank.py")
    page = documentation.page(model, trace).decode()
    for row in (["level", "2", "1", "", "0", "9", "level"],
                ["angle", "3", "deg", "", "-57.2958", "57.2958", "of &lt;the&gt; float"],
                ["open", "1", "Boolean", "true", "", "", "valve open"],
                ["turn", "4", "rad/s", "", "", "", "of the screw"],
                ["rate", "1", "1/s"], ["tilt", "14.3239", "deg"], ["locked", "true", ""],
                ["level", "no input"], ["angle", "flow"]):
        assert "<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" in page, row
    for heading, names in (("Inputs", ["flow", "open"]), ("Outputs", ["level", "angle", "turn", "full"]),
                           ("Parameters", ["rate", "tilt", "locked", "internal_step"])):
        table = page.partition(f"<h2>{heading}</h2>")[2].partition("</table>")[0]
        assert re.findall("<tr><td>(.*?)</td>", table) == names
    assert "<h3>tank</h3><pre>A &lt;tank&gt;.</pre>" in page and "resources/presets/slow.ssv" in page


def test_the_icon_is_a_picture_of_a_wedge(model):
    content, size = documentation.icon(model, 50), 50
    chunks, at = {}, 8
    while at < len(content):
        length, kind = struct.unpack(">I4s", content[at:at + 8])
        data = content[at + 8:at + 8 + length]
        assert struct.unpack(">I", content[at + 8 + length:at + 12 + length])[0] == zlib.crc32(kind + data)
        chunks[kind], at = data, at + 12 + length
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"] and content[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">IIBBBBB", chunks[b"IHDR"]) == (size, size, 8, 2, 0, 0, 0)
    pixels = zlib.decompress(chunks[b"IDAT"])
    rows = [pixels[y * (3 * size + 1):(y + 1) * (3 * size + 1)] for y in range(size)]
    white = [[x for x in range(size) if row[1 + 3 * x:4 + 3 * x] == b"\xff\xff\xff"] for row in rows]
    assert len(pixels) == size * (3 * size + 1) and {row[0] for row in rows} == {0}
    assert white[25] == list(range(5, 46))                                       # from tail to nose
    assert white[17] == white[33] == [5] and white[16] == white[34] == []        # as high at the tail as it gets
    assert white[21] == white[29] == list(range(5, 26))                          # half as high in the middle
    assert all(96 <= channel < 192 for channel in rows[0][1:4])


def test_the_table_in_c(model, trace):
    lines = generated_sources(model, trace)["model.h"].decode().splitlines()
    assert "enum { NV = 11, NX = 1, NU = 2, NP = 4, NY = 4, NC = 1, NS = 0 };" in lines
    assert "#define INTERNAL_STEP(p) ((p)[3])" in lines
    rows = [line.strip() for line in lines if line.startswith("    {")]
    assert rows[1] == '{"open", INPUT, 1, 1, 1, -1, 1.0, -DBL_MAX, DBL_MAX, "", 1.0},'
    assert rows[3] == f'{{"angle", OUTPUT, 0, 0, 1, -1, 0.0, -1.0, 1.0, " deg", {180 / pi!r}}},'
    assert rows[7] == f'{{"tilt", PARAMETER, 0, 0, 1, -1, 0.5, -DBL_MAX, 1.5, " deg", {180 / pi!r}}},'
    assert "static const unsigned INPUTS[] = {0, 1};" in lines
    assert "static const unsigned COMPUTED[] = {2, 3, 4, 5};" in lines
    assert "static const double Y_MINIMUM[] = {0.0, -1.0, -DBL_MAX, -DBL_MAX};" in lines
    assert "static const double Y_MAXIMUM[] = {9.0, 1.0, DBL_MAX, DBL_MAX};" in lines


def test_without_an_internal_step_a_communication_step_is_one(model):
    plain = tank(('    ("internal_step", "parameter", "s", 0.01, 0.001, 0.1, None, "longest internal step"),\n', ""))
    assert "#define INTERNAL_STEP(p) INFINITY" in generated_sources(plain, trace_model(plain))["model.h"].decode()


@pytest.mark.parametrize("step,longest,count", [(0.01, 0.001, 10), (0.01, 0.02, 1), (0.01, 0.01, 1), (0.011, 0.01, 2),
                                                (0.3, 0.1, 3), (1e-9, 1.0, 1), (0.01 * (1 + 1e-6), 0.01, 2)])
def test_internal_steps_are_no_longer_than_allowed(step, longest, count):
    assert internal_steps(step, longest) == count


def test_what_people_read_of_a_variable(model):
    table = {v.name: v for v in variables(model.VARIABLES)}
    shown = [table[n].unit_suffix for n in ("angle", "turn", "level", "open", "rate")]
    assert shown == [" deg", " rad/s", "", "", " 1/s"]
    assert table["angle"].displayed(pi) == pytest.approx(180) and table["turn"].displayed(pi) == pi
    assert [table[n].value_reference for n in ("flow", "angle")] == [0, 3]
    rate_of_an_angle = ("spin", "input", "rad/s", 0.5, None, None, None, "rate of an angle")
    assert variables([rate_of_an_angle])[0].display_unit == "deg/s"


@pytest.mark.parametrize("name,arguments", [
    *(("fmin", pair) for pair in ((1.0, 2.0), (2.0, 1.0), (2.0, 2.0))),
    *(("fmax", pair) for pair in ((1.0, 2.0), (2.0, 1.0), (2.0, 2.0))),
    *(("clip", (value, -1.0, 2.0)) for value in (-3.0, -1.0, 0.5, 2.0, 5.0)),
    *(("where", (condition, 3.0, 4.0)) for condition in (True, False)),
    *((name, (a, b)) for name in ("both", "either") for a in (True, False) for b in (True, False))])
def test_both_backends_agree(name, arguments):
    assert float(getattr(floats, name)(*arguments)) == float(getattr(symbols, name)(*map(symbols.SX, arguments)))
