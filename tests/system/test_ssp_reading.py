"""What an SSP file says becomes what the master flies: connections, units, parameters, experiment."""
import json

import pyarrow.parquet
import pytest
from altered import redescribed
from command import ahv, carried_out
from ssp_files import (
    component,
    connection,
    connector,
    gain,
    inline,
    linear,
    mapping,
    parameter,
    parameters,
    ssd,
    system,
    write,
)

from cosim import fly
from cosim.errors import UsageError
from cosim.ssp.load import load_ssp


@pytest.fixture
def read(tmp_path):
    """Reads the SSP with this description, and files."""
    def reading(description, **files):
        with load_ssp(write(tmp_path / "test.ssp", description, **files)) as found:
            return found
    return reading


def pair(start_unit, end_unit, inner="", **attributes):
    return ssd(system("root", component("a", y=start_unit) + component("b", u=end_unit),
                      connection("a.y", "b.u", inner, **attributes)))


@pytest.mark.parametrize("start,end,factor,offset", [
    ("km", "m", 1000, 0), ("m", "km", 0.001, 0), ("degC", "K", 1, 273.15), ("degF", "degC", 5 / 9, -160 / 9),
    ("m", "m", 1, 0), (None, "m", 1, 0), ("m", None, 1, 0)])
def test_units_are_converted(start, end, factor, offset, read):
    link, = read(pair(start, end)).connections
    assert (link.source, link.target) == ("a.y", "b.u")
    assert (link.factor, link.offset) == (pytest.approx(factor), pytest.approx(offset))


def test_the_linear_transformation_comes_after_the_conversion(read):
    link, = read(pair("degC", "K", linear(2, 1))).connections
    assert (link.factor, link.offset) == (2, pytest.approx(2 * 273.15 + 1))


def test_a_suppressed_conversion_leaves_the_linear_transformation(read):
    link, = read(pair("degC", "m", linear(2, 1), suppressUnitConversion="true")).connections
    assert (link.factor, link.offset) == (2, 1)


KELVIN = ('<UnitDefinitions><Unit name="degC"><BaseUnit K="1" offset="{}"/></Unit>'
          '<Unit name="K"><BaseUnit K="1"/></Unit></UnitDefinitions><TypeDefinitions>'
          '<SimpleType name="T"><Real unit="{}" relativeQuantity="{}"/></SimpleType>'
          '<SimpleType name="Mode"><Enumeration><Item name="low" value="3"/><Item name="high" value="7"/></Enumeration>'
          '</SimpleType></TypeDefinitions>')


@pytest.fixture
def warm(tmp_path):
    """Gain.fmu whose u, k and y are of a declared type in `unit`, a difference if `relative`; n is an Enumeration."""
    def made(unit="K", relative=True, offset=273.15):
        typed = KELVIN.format(offset, unit, str(relative).lower())
        return redescribed(gain(), tmp_path / "warm.fmu", ("<LogCategories>", f"{typed}<LogCategories>"),
                           ('<Real start="0"/>', '<Real declaredType="T" start="0"/>'),
                           ('<Real start="1"/>', '<Real declaredType="T" start="1"/>'),
                           ("<Real/>", '<Real declaredType="T"/>'),
                           ('<Integer start="0"/>', '<Enumeration declaredType="Mode" start="3"/>')).read_bytes()
    return made


def warm_component(name, bindings=""):
    """A component of the FMU that `warm` makes, whose connectors leave type and unit to the FMU."""
    bare = component(name, source="resources/Warm.fmu", bindings=bindings)
    return bare.replace("<ssc:Real/>", "")


@pytest.mark.parametrize("relative,value,mapped", [(True, 10, 21), (False, 283.15, 567.3)])
def test_a_parameter_that_is_a_difference_is_converted_as_one(relative, value, mapped, read, warm):
    names = mapping(f'<ssm:MappingEntry source="k" target="u">{linear(2, 1)}</ssm:MappingEntry>')
    values = inline(parameter("k", 10, unit="degC"))
    twice = inline(parameter("k", 10, unit="degC"), mapped=names)
    found = read(ssd(system("root", warm_component("a", values) + warm_component("b", twice))),
                 resources__Warm_dot_fmu=warm(relative=relative))
    assert found.components[0].values == {"k": pytest.approx(value)}
    assert found.components[1].values == {"u": pytest.approx(mapped)}


@pytest.mark.parametrize("relative,offset", [(True, 0), (False, 273.15)])
def test_a_connection_from_or_to_a_difference_is_converted_as_one(relative, offset, read, warm):
    elements = warm_component("a") + component("b", u="degC") + component("c", y="degC") + warm_component("d")
    found = read(ssd(system("root", elements, connection("a.y", "b.u") + connection("c.y", "d.u"))),
                 resources__Warm_dot_fmu=warm(relative=relative))
    assert [k.factor for k in found.connections] == [1, 1]
    assert [k.offset for k in found.connections] == [pytest.approx(-offset), pytest.approx(offset)]


@pytest.mark.parametrize("relative,value", [(True, 10), (False, 283.15)])
def test_a_systems_own_connector_gives_a_difference_to_a_difference(relative, value, read, warm):
    inner = system("root", warm_component("a"), connection(".in", "a.u"), connector("in", "input", "degC"),
                   inline(parameter("in", 10, unit="degC")))
    found = read(ssd(inner), resources__Warm_dot_fmu=warm(relative=relative))
    assert found.components[0].values == {"u": pytest.approx(value)}


def test_units_of_one_name_are_converted_by_their_definitions(read, warm):
    """degC is 0 at 273.15 K in the SSD and at 273 K in the FMU."""
    files = {"resources__Warm_dot_fmu": warm("degC", False, 273)}
    link, = read(ssd(system("root", component("b", y="degC") + warm_component("a"), connection("b.y", "a.u"))),
                 **files).connections
    assert (link.factor, link.offset) == (1, pytest.approx(0.15))
    values = inline(parameter("k", 10, unit="degC"))
    assert read(ssd(system("root", warm_component("a", values))), **files).components[0].values == {
        "k": pytest.approx(10.15)}
    with pytest.raises(UsageError, match=r"a\.u is in degC \(1 K1 \+ 273\.15\) in SystemStructure\.ssd and in degC "
                                         r"\(1 K1 \+ 273\) in Warm\.fmu\."):
        read(ssd(system("root", component("a", u="degC", source="resources/Warm.fmu"))), **files)


def test_an_item_of_an_enumeration_is_given_by_its_name(read, warm):
    files = {"resources__Warm_dot_fmu": warm()}
    values = inline(parameter("n", "high", "Enumeration"))
    assert read(ssd(system("root", warm_component("a", values))), **files).components[0].values == {"n": 7}
    with pytest.raises(UsageError, match=r"a\.n = hihg is not allowed; there are low, high\."):
        read(ssd(system("root", warm_component("a", values.replace("high", "hihg")))), **files)


def nested(connectors_unit=None, bindings=""):
    """a -> inner(b -> c) -> d, b and c inside a system of their own."""
    inner = system("inner", component("b", u="m", y="m", bindings=bindings) + component("c"),
                   connection(".in", "b.u") + connection("b.y", "c.u") + connection("c.y", ".out", linear(3, 1)),
                   connector("in", "input", connectors_unit) + connector("out", "output"))
    return system("root", component("a", y="km") + inner + component("d"),
                  connection("a.y", "inner.in", linear(2, 5)) + connection("inner.out", "d.u", linear(10, 0)))


@pytest.mark.parametrize("middle", [None, "km"])
def test_connections_lead_through_nested_systems_in_the_order_of_their_steps(middle, read):
    found = read(ssd(nested(middle)))
    assert [c.name for c in found.components] == ["a", "inner/b", "inner/c", "d"]
    links = {k.target: (k.source, k.factor, k.offset) for k in found.connections}
    assert links == {"inner/b.u": ("a.y", 2000, 5000), "inner/c.u": ("inner/b.y", 1, 0),
                     "d.u": ("inner/c.y", 30, 10)}


def test_root_connectors_may_stay_open_and_take_start_values(read):
    own = connector("in", "input", "km") + connector("other", "input") + connector("out", "output")
    links = connection(".in", "a.u", linear(2, 0)) + connection("a.y", ".out")
    found = read(ssd(system("root", component("a", u="m"), links, own, inline(parameter("in", 3)))))
    assert found.connections == ()
    assert found.components[0].values == {"u": 6000}


def test_values_of_every_type_reach_their_variables(read):
    values = inline(parameter("k", 2.5), parameter("n", 3, "Integer"), parameter("on", "0", "Boolean"),
                    parameter("label", "x &lt; y", "String"))
    found = read(ssd(system("root", component("a", bindings=values))))
    assert found.components[0].values == {"k": 2.5, "n": 3, "on": False, "label": "x < y"}


def test_later_bindings_come_before_earlier_ones_and_outer_before_inner(read):
    inner = inline(parameter("k", 1), parameter("n", 1, "Integer")) + inline(parameter("n", 2, "Integer"))
    outer = inline(parameter("k", 3), prefix="a.") + inline(parameter("a.on", "false", "Boolean"))
    found = read(ssd(system("root", component("a", bindings=inner), bindings=outer)))
    assert found.components[0].values == {"k": 3, "n": 2, "on": False}


def test_hierarchical_names_reach_into_nested_systems_and_others_are_told(read):
    values = inline(parameter("inner.b.k", 7), parameter("inner.c.n", 8, "Integer"), parameter("inner.b.kk", 9))
    found = read(ssd(nested().replace("<ssd:Elements>", f"<ssd:ParameterBindings>{values}</ssd:ParameterBindings>"
                                                        f"<ssd:Elements>", 1)))
    assert {c.name: c.values for c in found.components if c.values} == {"inner/b": {"k": 7}, "inner/c": {"n": 8}}
    assert found.ignored == ["the system: inner.b.kk"]


def test_a_parameter_is_converted_to_the_unit_of_its_connector(read):
    values = inline(parameter("k", 2, unit="km"))
    element = component("a", bindings=values, more=connector("k", "parameter", "m"))
    assert read(ssd(system("root", element))).components[0].values == {"k": 2000}


def test_a_mapping_renames_converts_and_transforms(read):
    names = mapping(f'<ssm:MappingEntry source="gain" target="k">{linear(2, 1)}</ssm:MappingEntry>',
                    '<ssm:MappingEntry source="gain" target="u" suppressUnitConversion="true"/>')
    values = inline(parameter("gain", 3, unit="km"), parameter("n", 5, "Integer"), mapped=names)
    element = component("a", u="m", bindings=values, more=connector("k", "parameter", "m"))
    assert read(ssd(system("root", element))).components[0].values == {"k": 6001, "u": 3}


@pytest.mark.parametrize("factor,offset,value", [(2, 0, 6), (1, 5, 8), (2, 5, 11), (1, 0, 3)])
def test_a_mapping_transforms_by_factor_and_offset(factor, offset, value, read):
    names = mapping(f'<ssm:MappingEntry source="gain" target="k">{linear(factor, offset)}</ssm:MappingEntry>')
    element = component("a", bindings=inline(parameter("gain", 3), mapped=names))
    assert read(ssd(system("root", element))).components[0].values == {"k": value}


def test_a_mapping_leaves_out_what_it_does_not_name_and_ignores_what_is_not_there(read):
    names = mapping('<ssm:MappingEntry source="gian" target="k"/>', '<ssm:MappingEntry source="count" target="n"/>')
    values = inline(parameter("k", 3), parameter("count", 5, "Integer"), mapped=names)
    found = read(ssd(system("root", component("a", bindings=values))))
    assert found.components[0].values == {"n": 5} and found.ignored == []


@pytest.mark.parametrize("text,value", [("true", True), ("1", True), ("false", False), ("0", False)])
def test_a_truth_is_written_in_words_or_digits(text, value, read):
    element = component("a", bindings=inline(parameter("on", text, "Boolean")))
    assert read(ssd(system("root", element))).components[0].values == {"on": value}


def test_a_value_with_a_unit_of_its_own_keeps_its_number_where_the_variable_has_none(read):
    element = component("a", bindings=inline(parameter("k", 2, unit="km")))
    assert read(ssd(system("root", element))).components[0].values == {"k": 2}


def test_a_connection_without_units_keeps_the_unit_of_its_start(read):
    """Through a connector without a unit: km arrive as m, once."""
    inner = system("inner", component("b", u="m"), connection(".in", "b.u"), connector("in", "input"))
    root = system("root", component("a", y="km") + inner, connection("a.y", "inner.in"))
    assert [k.factor for k in read(ssd(root)).connections] == [1000]
    suppressed = root.replace('endConnector="in"', 'endConnector="in" suppressUnitConversion="true"')
    assert [k.factor for k in read(ssd(suppressed)).connections] == [1]


def test_a_binding_says_its_type(read):
    kind = "application/x-ssp-parameter-set"
    element = component("a", bindings=inline(parameter("k", 3), type=kind))
    assert read(ssd(system("root", element))).components[0].values == {"k": 3}


def test_the_experiment_starts_and_stops_as_the_file_says(read):
    found = read(ssd(system("root", component("a")), '<ssd:DefaultExperiment startTime="2" stopTime="4"/>'))
    assert (found.start, found.stop) == (2, 4)
    assert read(ssd(system("root", component("a")), '<ssd:DefaultExperiment stopTime="4"/>')).start == 0


def test_a_system_flies_from_the_start_that_its_file_says(tmp_path):
    experiment = '<ssd:DefaultExperiment startTime="2" stopTime="4"/>'
    with load_ssp(write(tmp_path / "test.ssp", ssd(system("root", component("a")), experiment))) as found:
        flight = fly(found, 0.5)
    assert flight.finished and flight.time.tolist() == [2, 2.5, 3, 3.5, 4]


def test_files_of_a_loaded_system_go_with_it(tmp_path):
    with load_ssp(write(tmp_path / "test.ssp", ssd(system("root", component("a"))))) as found:
        fmu, = (c.fmu for c in found.components)
        assert fmu.is_file()
    assert not fmu.exists()


def test_parameter_sets_are_read_from_the_archive_and_from_the_fmu(read, native_fmus):
    files = {"resources__my values_dot_ssv": parameters(parameter("k", 4)),
             "resources__AhvScenario_dot_fmu": native_fmus["AhvScenario"].read_bytes()}
    other = ('<ssd:Component name="s" source="resources/AhvScenario.fmu"><ssd:ParameterBindings>'
             '<ssd:ParameterBinding source="resources/presets/hold.ssv" sourceBase="component"/>'
             '</ssd:ParameterBindings></ssd:Component>')
    element = component("a", bindings='<ssd:ParameterBinding source="resources/my%20values.ssv"/>')
    found = read(ssd(system("root", element + other)), **files)
    assert found.components[0].values == {"k": 4}
    assert found.components[1].values["V_command_step"] == 0


def test_the_experiment_is_the_files_or_the_fmus(read, native_fmus):
    one = system("root", component("a"))
    assert (read(ssd(one)).stop, read(ssd(one)).step) == (1, None)
    annotation = ('<ssd:Annotations><ssc:Annotation type="org.openmodelica"><x:FixedStepMaster xmlns:x="urn:oms" '
                  'stepSize="0.125"/></ssc:Annotation></ssd:Annotations></ssd:System>')
    assert read(ssd(one.replace("</ssd:System>", annotation))).step == 0.125
    scenario = system("root", '<ssd:Component name="s" source="resources/AhvScenario.fmu"/>')
    found = read(ssd(scenario, ""), resources__AhvScenario_dot_fmu=native_fmus["AhvScenario"].read_bytes())
    assert (found.stop, found.step) == (100, 0.01)


def test_a_system_flies_with_its_conversions(tmp_path):
    description = ssd(system("root", component("a", y="km", bindings=inline(parameter("u", 2), parameter("k", 3)))
                             + component("b", u="m"), connection("a.y", "b.u", linear(2, 1))))
    path = write(tmp_path / "test.ssp", description)
    found = json.loads(ahv("simulate", path, "--step", 0.25, "--out", tmp_path / "out", "--json"))
    assert found == {"system": "test", "components": ["a", "b"], "algorithm": "gauss-seidel", "step_s": 0.25,
                     "stop_s": 1.0, "start_s": 0.0, "ticks": 4, "finished": True, "departed_at_s": None,
                     "ended_at_s": None,
                     "real_time_factor": found["real_time_factor"], "out": str(tmp_path / "out")}
    table = pyarrow.parquet.read_table(tmp_path / "out" / "signals.parquet")
    assert table["a.y"].to_pylist() == [0, 6, 6, 6, 6]
    assert table["b.y"].to_pylist() == [0, 12001, 12001, 12001, 12001]
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["fmus"]["a"]["file"] == f"{path}/resources/Gain.fmu"


def test_a_jacobi_step_is_one_step_late(tmp_path):
    description = ssd(system("root", component("a", bindings=inline(parameter("u", 2))) + component("b"),
                             connection("a.y", "b.u")))
    path = write(tmp_path / "test.ssp", description)
    ahv("simulate", path, "--step", 0.25, "--algorithm", "jacobi", "--out", tmp_path / "out")
    table = pyarrow.parquet.read_table(tmp_path / "out" / "signals.parquet")
    assert table["b.y"].to_pylist() == [0, 0, 2, 2, 2]


def test_what_tools_write_beside_the_schema_is_passed_over_and_told(read, capsys):
    element = component("a").replace("</ssd:Component>", "<ssd:ParameterBindings/></ssd:Component>")
    inner = system("root", element).replace("<ssd:Elements>", "<ssd:Connectors/><ssd:Elements>")
    found = read(ssd(inner, '<ssd:DefaultExperiment start="10" stopTime="1"/>'))
    assert found.stop == 1 and [c.name for c in found.components] == ["a"]
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 3 and "The attribute 'start' is not allowed. That is ignored." in told[-1]


def test_an_fmu_that_crashes_ends_the_run_and_what_was_flown_is_kept(tmp_path):
    path = write(tmp_path / "test.ssp", ssd(system("root", component(
        "a", bindings=inline(parameter("label", "crash", "String"))))))
    said = ahv("simulate", path, "--step", 0.25, "--out", tmp_path / "out", status=1)
    assert "a (Gain.fmu)" in said and len(said.strip().splitlines()) == 1
    assert not json.loads((tmp_path / "out" / "run.json").read_text())["finished"]
    assert pyarrow.parquet.read_table(tmp_path / "out" / "signals.parquet")["time"].to_pylist() == [0, 0.25, 0.5, 0.75]


CHAIN = component("a", y="m") + component("b", u="s")
REFUSED = {
    "a unit that cannot be converted": (system("root", CHAIN, connection("a.y", "b.u")),
                                        "from a.y to b.u cannot convert m to s"),
    "a factor that is no number": (system("root", component("a") + component("b"),
                                          connection("a.y", "b.u", linear("NaN", 0))),
                                   "from a.y to b.u has the factor nan and the offset 0; they have to be finite"),
    "an unknown connector": (system("root", CHAIN, connection("a.yy", "b.u")),
                             "the connector yy, which a does not have; did you mean y?"),
    "an unknown element": (system("root", CHAIN, connection("aa.y", "b.u")),
                           "starts at aa, which is no element of it; did you mean a?"),
    "a connector that the FMU has not": (system("root", component("a", more=connector("kk", "parameter"))),
                                         "has a connector kk, but Gain.fmu has no such variable; did you mean k?"),
    "a connector of another type": (system("root", component("a", more=connector("n", "parameter"))),
                                    "a.n is Real in SystemStructure.ssd and Integer in Gain.fmu"),
    "a connection against the stream": (system("root", CHAIN, connection("b.u", "a.y")),
                                        "starts at b.u, which is an input"),
    "two connections to one input": (system("root", component("a") + component("b"),
                                            connection("a.y", "b.u") + connection("b.y", "b.u")),
                                     "b.u has more than one connection"),
    "a signal dictionary": (system("root", '<ssd:SignalDictionaryReference name="bus" dictionary="d"/>'),
                            "bus is a SignalDictionaryReference, which is not supported"),
    "an SSP in an SSP": (system("root", '<ssd:Component name="x" source="x.ssp" type="application/x-ssp-package"/>'),
                         "x is of type application/x-ssp-package, which is not supported"),
    "model exchange": (system("root", component("a").replace("<ssd:Component", '<ssd:Component '
                                                             'implementation="ModelExchange"')), "ModelExchange"),
    "a missing FMU": (system("root", component("a", source="resources/Gian.fmu")),
                      "The component a refers to resources/Gian.fmu, which is not in the SSP"),
    "an FMU elsewhere": (system("root", component("a", source="../../Gain.fmu")), "leads outside of the SSP"),
    "an FMU on the network": (system("root", component("a", source="http://host/Gain.fmu")), "not inside the SSP"),
    "a file that is no FMU": (system("root", component("a", source="SystemStructure.ssd")), "is not a zip file"),
    "a missing parameter set": (system("root", component("a", bindings='<ssd:ParameterBinding source="x.ssv"/>')),
                                "The ParameterBinding of a refers to x.ssv, which is not in the SSP"),
    "a parameter of a wrong unit": (
        system("root", component("a", u="m", bindings=inline(parameter("u", 1, unit="s")))),
        "The value of a.u cannot be converted from s to m"),
    "a mapping of another kind": (
        system("root", CHAIN, connection("a.y", "b.u", '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" '
                                         'target="false"/></ssc:BooleanMappingTransformation>')),
        "has a BooleanMappingTransformation, which is not supported"),
    "a parameter binding of another type": (
        system("root", component("a", bindings=inline(parameter("k", 3), type="text/csv"))),
        "A parameter binding of a is of type text/csv, which is not supported"),
    "a binding of nothing": (system("root", component("a", bindings="<ssd:ParameterBinding/>")),
                             "The ParameterBinding of a has neither a source nor content"),
    "a parameter set that is not in the FMU": (
        system("root", component("a", bindings='<ssd:ParameterBinding source="x.ssv" sourceBase="component"/>')),
        "The ParameterBinding of a refers to x.ssv, which is not in Gain.fmu"),
    "a parameter set in the FMU of a system": (
        system("root", component("a"), bindings='<ssd:ParameterBinding source="x.ssv" sourceBase="component"/>'),
        "The ParameterBinding of the system has its source in a component, but is not in one"),
    "a transformation of a whole number": (
        system("root", component("a", bindings=inline(parameter("n", 3, "Integer"), mapped=mapping(
            f'<ssm:MappingEntry source="n" target="n">{linear(2, 0)}</ssm:MappingEntry>')))),
        "The mapping of n to n has a LinearTransformation, but a value that is Integer"),
    "a binary parameter": (system("root", component("a", bindings=inline(
        '<ssv:Parameter name="k"><ssv:Binary mime-type="x" value="00"/></ssv:Parameter>'))),
        "The parameter k is Binary, which is not supported"),
    "two elements of one name": (system("root", component("a") + component("a")), "There are two elements called a"),
    "two elements of one flat name": (system("root", component("a.u") + system("a", component("u"))),
                                      "Two components are called a/u once nested systems and dots are written with /"),
    "a circle": (system("root", component("a") + system(
        "s", component("b"), connection(".in", ".out"), connector("in", "input") + connector("out", "output")),
        connection("s.out", "s.in") + connection("s.out", "a.u")), "The connections lead in a circle through "),
    "nothing to fly": ('<ssd:System name="root"/>', "The system has no components"),
}


@pytest.mark.parametrize("inner,sentence", REFUSED.values(), ids=REFUSED)
def test_what_is_not_supported_is_refused_by_name(inner, sentence, read):
    with pytest.raises(UsageError) as error:
        read(ssd(inner))
    assert sentence in str(error.value)


def test_a_step_that_nobody_gives_is_that_of_run_and_told(tmp_path):
    path = write(tmp_path / "test.ssp", ssd(system("root", component("a"))))
    done = carried_out("simulate", path, "--out", tmp_path / "out", "--json")
    assert json.loads(done.stdout)["step_s"] == 0.01
    assert "does not say how large the step is: 0.01 s is taken" in done.stderr


def test_a_later_ssp_version_is_refused_by_name(read):
    with pytest.raises(UsageError, match=r"is an SSP 3.0 system structure description; SSP 1.0 and 2.0 are what runs"):
        read(ssd(system("root", component("a")), version="3.0"))


def test_a_parameter_that_fits_nothing_is_told_and_the_summary_is_of_what_flew(tmp_path):
    values = inline(parameter("k", 2.5), parameter("wings", 2))
    path = write(tmp_path / "test.ssp", ssd(system("root", component("a", bindings=values))))
    done = carried_out("simulate", path, "--step", "0.25", "--stop", "1", "--out", tmp_path / "out", "--json")
    assert "the parameter a: wings fits no variable and is ignored" in done.stderr
    summary = json.loads(done.stdout)
    assert (summary["ticks"], summary["step_s"], summary["stop_s"], summary["finished"]) == (4, 0.25, 1, True)
    assert (summary["departed_at_s"], summary["components"], summary["out"]) == (None, ["a"], str(tmp_path / "out"))
    assert summary["real_time_factor"] > 0 and done.returncode == 0
