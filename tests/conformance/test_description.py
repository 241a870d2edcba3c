"""What every FMU of ours says of itself in modelDescription.xml and beside it, in both flavours."""
import re
import tomllib
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest
from lxml import etree

from cosim.errors import RunError
from cosim.master.fmu import FmuFile
from cosim.master.instance import Instance
from cosim.vehicle.registry import MODELS

ROOT = Path(__file__).parents[2]


@pytest.fixture(params=["native_fmus", "python_fmus"])
def fmus(request) -> dict[str, Path]:
    return request.getfixturevalue(request.param)


@pytest.mark.parametrize("name", MODELS)
def test_author_copyright_and_licence_travel_with_the_fmu(fmus, name):
    with zipfile.ZipFile(fmus[name]) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
        licence = archive.read("documentation/licenses/license.txt")
        carried = [path for path in archive.namelist() if path.startswith("resources/pythonfmu/")]
        if carried:
            assert b"MIT License" in archive.read("documentation/licenses/pythonfmu.txt")
    assert root.get("author") == "the AHV FMU authors"
    assert root.get("copyright") == "Copyright 2026 the AHV FMU authors"
    assert root.get("license") == "BSD-2-Clause"
    assert licence == (ROOT / "LICENSE").read_bytes() and b"Copyright (c) 2026, the AHV FMU authors" in licence


def test_an_fmu_names_what_made_it_with_versions(native_fmus, python_fmus):
    made_by = {"native": native_fmus, "python": python_fmus}
    tools = {flavour: FmuFile.open(fmus["AhvPlant"]).description.generationTool for flavour, fmus in made_by.items()}
    assert tools == {"native": f"ahv {version('ahv')}, casadi {version('casadi')}, ziglang {version('ziglang')}",
                     "python": f"ahv {version('ahv')}, casadi {version('casadi')}, pythonfmu {version('pythonfmu')}"}


def test_what_decides_on_an_fmus_bytes_is_pinned_exactly_and_as_the_locks_have_it():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needed = [*project["dependencies"], *project["optional-dependencies"]["native"]]
    for name in ("casadi", "ziglang", "pythonfmu"):
        pin, = (line for line in needed if line.startswith(name))
        assert re.fullmatch(rf"{name}==[\d.]+", pin)
        assert pin in (ROOT / "requirements" / "all.txt").read_text().split()


@pytest.mark.parametrize("variable, told", [("reference_omega", "1000 rad/s is above its maximum 100 rad/s"),
                                            ("elevator_max", "57295.8 deg is above its maximum 90 deg")])
def test_a_refusal_gives_a_frequency_in_radians_per_second_and_an_angle_in_degrees(fmus, variable, told):
    file = FmuFile.open(fmus["AhvController"])
    instance = Instance(file, "controller")
    try:
        with pytest.raises(RunError, match=f"{variable} = {told}"):
            instance.set({variable: 1000.0})
    finally:
        instance.close()
        file.close()
