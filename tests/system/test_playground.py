"""The page that flies in a browser, as a file: what it has in it, and that it loads nothing."""
import base64
import hashlib
import json
import re

import pytest
import typer

from cosim.cli.app import app
from cosim.playground import write
from cosim.vehicle.closed_loop import CLOSED_LOOP
from cosim.vehicle.metrics import METRICS
from cosim.vehicle.registry import LAWS, PLANTS
from cosim.vehicle.scenarios import BUILT_IN

MOST = 2_000_000             # bytes of the page
MODULE = 4 * (1 << 20) / 3   # of the module in it at most, in base64
STAND_IN = b"the module"


@pytest.fixture(scope="module")
def page(native_fmus) -> str:
    return write.page(STAND_IN)


@pytest.fixture(scope="module")
def data(page) -> dict:
    found = re.search(r'<script type="application/json" id="about">(.*?)</script>', page, re.DOTALL)
    assert found
    return json.loads(found[1])


def test_the_page_has_the_module_it_is_given(data):
    assert base64.b64decode(data["module"]) == STAND_IN


def test_the_page_is_small(page):
    assert 100_000 < len(page.encode()) < MOST - MODULE


def test_the_page_loads_nothing_and_may_not(page):
    tags = re.findall(r"<(?:script|link|img|iframe|source|form|a)\b[^>]*>", page)
    assert [tag for tag in tags if re.search(r"""(?:src|href|action)=["'](?!#|data:,)""", tag)] == []
    assert not re.search(r"@import|url\(", page)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy and policy[1].startswith("default-src 'none';") and "http" not in policy[1]


def test_the_policy_names_each_script_and_the_style(page):
    texts = re.findall(r'<(?:style|script)(?! type="application/json")[^>]*>(.*?)</(?:style|script)>', page, re.DOTALL)
    assert len(texts) == 3
    for text in texts:
        assert f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'" in page


def test_no_text_of_an_fmu_ends_the_data():
    hostile = {"description": "</script><script>alert(1)</script><!-- \u2028 ]]>"}
    text = write.embedded(hostile)
    assert "<" not in text and json.loads(text) == hostile


def test_the_drawing_library_is_the_one_whose_licence_is_there(page):
    library = write.read("uplot/uPlot.iife.min.js")
    assert library.startswith("/*! https://github.com/leeoniya/uPlot (v1.6.32) */") and library in page
    assert "Copyright (c) 2022 Leon Sorokin" in page


def test_the_page_knows_what_the_registry_and_the_fmus_have(data, native_fmus):
    from cosim.master.fmu import preset
    from cosim.master.info import info

    assert list(data["laws"]) == list(LAWS) and list(data["plants"]) == list(PLANTS)
    assert list(data["metrics"]) == list(METRICS)
    for name, path in native_fmus.items():
        declared, known = info(path), data["fmus"][name]
        parameters = {v.name for v in declared.variables if v.causality == "parameter"}
        assert {n for n, v in known["variables"].items() if v["causality"] == "parameter"} == parameters
        assert tuple(known["presets"]) == declared.presets
        for word in declared.presets:
            assert known["presets"][word] == preset(path, word)


def test_every_pair_of_law_and_plant_has_the_calls_of_the_master(data):
    wired = {(target, name): source for source, target, names in CLOSED_LOOP for name in names}
    for law in LAWS:
        for plant in PLANTS:
            tick = data["plans"][law][plant]["tick"]
            assert [call[1] for call in tick if call[0] == "step"] == ["scenario", "controller", "plant"]
            given = {(call[1], name): source for call in tick if call[0] == "set"
                     for name, source in zip(call[2], call[3])}
            assert given == {to: f"{source}.{to[1]}" for to, source in wired.items()}
            read = [name for call in tick if call[0] == "get" for name in call[3]]
            assert read == data["plans"][law][plant]["columns"]


def names_in(expression) -> list[str]:
    return [expression] if isinstance(expression, str) else [n for part in expression[1:] for n in names_in(part)]


def test_the_page_computes_the_metrics_of_a_run(data):
    known = set(re.findall(r"^  \"?([\w+-]+)\"?(?:: \(|\()", write.read("measures.js"), re.MULTILINE))
    trees = [metric["expression"] for metric in data["metrics"].values()]
    while trees:
        name, *parts = trees.pop()
        assert name in known
        trees += [part for part in parts if isinstance(part, list)]


def test_what_the_layout_names_exists(data):
    known = {c: set().union(*(data["fmus"][m]["variables"] for m in models)) for c, models in (
        ("scenario", [data["scenario"]["fmu"]]), ("controller", [law["fmu"] for law in data["laws"].values()]),
        ("plant", [plant["fmu"] for plant in data["plants"].values()]))}
    for section in data["layout"]["sections"]:
        if isinstance(section.get("variables"), list):
            assert set(section["variables"]) <= known[section["component"]]
        for signal in (name for names in section.get("swings", {}).values() for name in names):
            assert all(f"{signal}_{part['variable']}" in known["scenario"] for part in data["layout"]["swing"])
    signals = {name for plans in data["plans"].values() for one in plans.values() for name in one["columns"]}
    drawn = {name for panel in data["layout"]["panels"] for line in panel["lines"]
             for name in names_in(line["expression"])}
    assert {data["stands_in"].get(name, name) for name in drawn} <= signals


def test_what_is_flown_by_default_is_what_ahv_run_flies(data):
    options = {option.name: option.default for option in typer.main.get_command(app).commands["run"].params}
    assert (data["algorithm"], data["step"]) == (options["algorithm"], options["step"])
    assert {name: case["stop"] for name, case in data["scenarios"].items()} == {
        name: case.stop for name, case in BUILT_IN.items()}
