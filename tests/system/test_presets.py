"""Presets: SSP parameter sets that an FMU carries in resources/presets, read once for all who ask."""
import shutil
import zipfile
from importlib import import_module

import pytest
from altered import redescribed
from ssp_files import gain, parameter, parameters

from cosim.errors import UsageError
from cosim.master.fmu import FmuFile, preset
from cosim.vehicle.registry import MODELS

DESCRIBED = (("<LogCategories>", '<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>'
              '<TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="low" value="3"/></Enumeration>'
              '</SimpleType></TypeDefinitions><LogCategories>'),
             ('<Integer start="0"/>', '<Enumeration declaredType="Mode" start="3"/>'),
             ('<Real start="1"/>', '<Real start="1" unit="m"/>'))


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("flavour", ["python_fmus", "native_fmus"])
def test_a_preset_is_what_the_model_says(name, flavour, request):
    path, model = request.getfixturevalue(flavour)[name], import_module(MODELS[name])
    for word, values in model.PRESETS.items():
        found = preset(path, word)
        assert found == values
        assert [isinstance(x, bool) for x in found.values()] == [isinstance(x, bool) for x in values.values()]
        with FmuFile.open(path) as file:
            assert file.preset(word) == found
            for key, value in found.items():
                assert file.checked(key, value, "it") == value


def test_truths_of_the_presets_are_both(native_fmus):
    fmu = native_fmus["AhvController"]
    assert [preset(fmu, word)["z3_from_pitch_rate"] for word in ("calibrated", "printed")] == [True, False]


def with_preset(path, name, content):
    """Gain.fmu with k in m, n an Enumeration, and one preset."""
    redescribed(gain(), path, *DESCRIBED)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(f"resources/presets/{name}.ssv", content)
    return path


def test_a_strangers_preset_has_units_items_and_every_type(tmp_path):
    content = parameters(parameter("k", 2.5, unit="km"), parameter("n", "low", "Enumeration"),
                         parameter("on", "0", "Boolean"), parameter("label", "x &lt; y", "String"),
                         parameter("u", -3), parameter("whole", 4, "Integer"))
    path = with_preset(tmp_path / "Gain.fmu", "mild", content)
    assert preset(path, "mild") == {"k": 2500.0, "n": 3, "on": False, "label": "x < y", "u": -3.0, "whole": 4}


@pytest.mark.parametrize("content,sentence", [
    ("not XML", r"mild\.ssv of Gain\.fmu is not well-formed XML"), ("<a/>", "is not an SSP parameter set"),
    (parameters(parameter("k", "much")), "is not a valid SSP 1.0 parameter set"),
    (parameters(parameter("k", 1, unit="s")), "The value of k cannot be converted from s to m"),
    (parameters(parameter("n", "lwo", "Enumeration")), "n = lwo is not allowed; there are low"),
    ('<!DOCTYPE d [<!ENTITY a "b">]>' + parameters(parameter("k", 1)).partition("?>")[2], "declares a document type")])
def test_a_preset_that_cannot_be_read_is_refused_by_name(tmp_path, content, sentence):
    with pytest.raises(UsageError, match=sentence):
        preset(with_preset(tmp_path / "Gain.fmu", "mild", content), "mild")


def test_a_preset_that_is_not_there_is_named_with_those_that_are(tmp_path):
    path = with_preset(tmp_path / "Gain.fmu", "mild", parameters(parameter("k", 1)))
    with pytest.raises(UsageError, match=r"Gain\.fmu has no preset midl; it has mild\."):
        preset(path, "midl")
    plain = tmp_path / "Plain.fmu"
    plain.write_bytes(gain())
    with pytest.raises(UsageError, match=r"Plain\.fmu has no preset mild; it has none\."):
        preset(plain, "mild")
    with pytest.raises(UsageError, match="There is no FMU at"):
        preset(tmp_path / "nothing.fmu", "mild")
    shutil.copy(__file__, tmp_path / "text.fmu")
    with pytest.raises(UsageError, match=r"text\.fmu cannot be read as an FMU: 'text\.fmu' is not a zip file"):
        preset(tmp_path / "text.fmu", "mild")
