"""Which values and components need which, from what FMUs declare; loops, also of an FMU with itself."""
from pathlib import Path

import pytest

from cosim.master.dependencies import direct_needs, inputs_behind, looped, step_order, value_needs
from cosim.master.description import usable
from cosim.master.fmu import FmuFile
from cosim.master.initialise import order
from cosim.master.system import Component, Connection, System

XML = """<fmiModelDescription fmiVersion="2.0"><CoSimulation modelIdentifier="m"/><ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="v" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="p" valueReference="2" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="3" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="z" valueReference="4" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="silent" valueReference="5" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="left_out" valueReference="6" causality="output"><Real/></ScalarVariable>
</ModelVariables><ModelStructure>
<Outputs><Unknown index="4" dependencies="1 3"/><Unknown index="5" dependencies=""/><Unknown index="6"/></Outputs>
<InitialUnknowns><Unknown index="4" dependencies=""/><Unknown index="5" dependencies="2 3"/><Unknown index="6"/>
</InitialUnknowns></ModelStructure></fmiModelDescription>"""
BOTH = {"u", "v"}


def flown(*names, links):
    """(system, files, targets) of FMUs with this description, connected as `links` say, source to target."""
    file = FmuFile(Path("m.fmu"), Path(), usable(XML.encode()), "")
    system = System([Component(n, "m.fmu") for n in names], [Connection(a, b) for a, b in links])
    return system, dict.fromkeys(names, file), {k.target: k for k in system.connections}


def test_the_inputs_behind_an_output_are_those_declared_or_all():
    file = flown("a", links=[])[1]["a"]
    assert inputs_behind(file) == {"y": {"u"}, "z": set(), "silent": BOTH, "left_out": BOTH}
    assert inputs_behind(file, initially=True) == {"y": set(), "z": {"v"}, "silent": BOTH, "left_out": BOTH}


@pytest.mark.parametrize("initially,behind", [(False, {"a.y": ["a.u"], "a.z": []}),
                                              (True, {"a.y": [], "a.z": ["a.v"]})])
def test_values_need_other_ones_at_the_start_than_later(initially, behind):
    links = [("b.z", "a.u"), ("b.y", "a.v"), ("a.y", "b.u"), ("a.z", "b.v")]
    needs = value_needs(*flown("a", "b", links=links), initially=initially)
    assert {name: needs[name] for name in behind} == behind
    assert needs["a.u"] == ["b.z"] and needs["a.v"] == ["b.y"] and needs["b.u"] == ["a.y"]


def test_an_output_that_needs_an_input_that_is_not_connected_waits_for_nothing():
    needs = value_needs(*flown("a", "b", links=[("a.y", "b.v"), ("a.silent", "b.u")]))
    assert needs == {"a.silent": [], "a.y": [], "b.u": ["a.silent"], "b.v": ["a.y"]}


@pytest.mark.parametrize("source,target,loops", [("a.y", "a.u", {"a"}), ("a.y", "a.v", set()), ("a.z", "a.u", set()),
                                                 ("a.silent", "a.v", {"a"})])
def test_an_fmu_wired_to_itself_is_a_loop_where_its_output_needs_that_input(source, target, loops):
    world = flown("a", "b", links=[(source, target), ("b.z", "a.v" if target == "a.u" else "a.u")])
    assert looped(value_needs(*world)) == loops
    assert step_order(*world) == [["a"], ["b"]] or step_order(*world) == [["b"], ["a"]]


def test_an_fmu_wired_to_itself_initialises_as_it_declares_for_the_start():
    system, files, targets = flown("a", links=[("a.y", "a.u"), ("a.z", "a.v")])
    batches = order(system, files, targets)
    assert [sorted(n for batch in step for n in batch) for step in batches] == [["a.y"], ["a.v", "a.z"], ["a.u"]]
    assert [len(step) for step in batches] == [1, 2, 1]


def test_a_component_needs_those_that_feed_what_its_outputs_show_at_once():
    """p.v is behind no output but those that say nothing."""
    world = flown("a", "b", "c", links=[("b.z", "a.u"), ("c.z", "a.v")])
    assert direct_needs(*world) == {"a": ["b", "c"], "b": [], "c": []}
    assert step_order(*world) == [["b"], ["c"], ["a"]]


def test_components_step_after_those_they_need_and_else_as_the_system_has_them():
    world = flown("d", "c", "b", "a", links=[("a.z", "d.u"), ("b.z", "a.u")])
    assert step_order(*world) == [["c"], ["b"], ["a"], ["d"]]
    loop = flown("d", "c", "b", "a", links=[("a.y", "c.u"), ("c.y", "a.u"), ("a.z", "b.u")])
    assert step_order(*loop) == [["d"], ["c", "a"], ["b"]]


@pytest.mark.parametrize("links,steps", [
    ([("b.z", "a.u"), ("a.y", "b.u")], [["a.y"], ["b.u"], ["b.z"], ["a.u"]]),
    ([("a.z", "b.v"), ("b.z", "a.u"), ("a.y", "c.u")], [["a.y"], ["a.z"], ["b.v"], ["c.u"], ["b.z"], ["a.u"]]),
])
def test_what_depends_on_nothing_is_read_first(links, steps):
    names = sorted({end.partition(".")[0] for link in links for end in link})
    found = order(*flown(*names, links=links))
    flat = [name for step in found for batch in step for name in batch]
    place = {name: i for i, name in enumerate(flat)}
    assert sorted(flat) == sorted({end for link in links for end in link}) and all(len(step) == 1 for step in found)
    for source, target in links:
        assert place[source] < place[target]
    needs = value_needs(*flown(*names, links=links), initially=True)
    assert all(place[needed] < place[name] for name in needs for needed in needs[name])
    assert len(flat) == len([n for step in steps for n in step])
