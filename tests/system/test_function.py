"""A system as a function from values to figures, and what OpenTURNS and gemseo make of one."""

import importers
import numpy as np
import pytest
import small
from test_environment import mass

import cosim
from cosim.errors import RunError, UsageError

FIGURES = {"last": lambda flight: flight["mass.y"][-1], "peak": lambda flight: flight["mass.y"].max()}
ROOT = importers.ROOT


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return small.build(tmp_path_factory.mktemp("functions"))


def test_a_function_gives_the_figures_of_flights(fmu):
    with cosim.Function(mass(fmu), ["mass.a21", "mass.x1"], FIGURES) as function:
        found = function([[-9.0, 1.0], [-4.0, 2.0], [-9.0, 1.0]])
        flights = [cosim.fly(mass(fmu, a21=a21, x1=x1), progress=False) for a21, x1 in ((-9.0, 1.0), (-4.0, 2.0))]
        assert found.shape == (3, 2) and (function([-4, 2]) == found[1]).all() and (found[0] == found[2]).all()
        assert (found[:2] == [[figure(flight) for figure in FIGURES.values()] for flight in flights]).all()
        assert function(np.empty((0, 2))).shape == (0, 2)


def test_figures_may_be_expressions_on_any_signals(fmu):
    figures = {"peak": "max(mass.y)", "late": "first(mass.y < 0)", "odd": "1 / (final(mass.a21) + 4)"}
    flight = cosim.fly(mass(fmu), record=["mass.y"], progress=False)
    with cosim.Function(mass(fmu), ["mass.x1"], {"peak": figures["peak"], **FIGURES}) as function:
        assert (function([1.0]) == [flight["mass.y"].max(), flight["mass.y"][-1]]).all()
    with cosim.Function(mass(fmu), ["mass.x1"], figures, lost=-1.0) as function:
        assert function([1.0])[2] == -1.0 and 0.7 < function([1.0])[1] < 0.9
    with cosim.Function(mass(fmu), ["mass.x1"], figures) as function, pytest.raises(RunError, match="odd: "):
        function([1.0])


def test_a_flight_that_is_lost_is_an_error_or_the_number_that_was_asked_for(fmu):
    inputs, fault = ["mass.fault", "mass.fault_time"], small.FAULTS.index
    with cosim.Function(mass(fmu), inputs, FIGURES) as function:
        well = function([0, 0.5])
        for name in ("discard", "fatal", "refuse_init", "fatal_init"):
            with pytest.raises(RunError):
                function([fault(name), 0.5])
        assert (function([0, 0.5]) == well).all() and (function([fault("end"), 0.5]) != well).any()
    with cosim.Function(mass(fmu), inputs, FIGURES, lost=99.0) as function:
        assert (function([fault("error"), 0.5]) == 99.0).all() and (function([fault("fatal_init"), 0.5]) == 99.0).all()
        assert (function([0, 0.5]) == well).all()


@pytest.mark.parametrize("options,words", [
    ({"inputs": "mass.x1"}, "inputs = 'mass.x1' is not allowed: it must be a list of names."),
    ({"inputs": ["mass.xx"]}, "has no variable xx"), ({"inputs": ["wing.x"]}, "There is no component wing"),
    ({"inputs": ["mass.x1", "mass.x2"]}, "there must be 2 in a row, for mass.x1, mass.x2."),
    ({"record": ["mass.z"]}, "record mass.z fits no numeric variable"), ({"values": [np.nan]}, "mass.x1 = nan"),
    ({"figures": {"peak": "mass.y"}}, "peak: 'mass.y' is a signal"),
    ({"figures": {"peak": "max(mass.yy)"}}, "figures: mass.yy is no variable that is a number"),
    ({"figures": {"peak": 3}}, "peak = 3 is not allowed"),
    ({"stop": 0.015}, "stop 0.015 s is not a whole number of communication steps"),
])
def test_what_does_not_fit_is_one_sentence(fmu, options, words):
    given = {"system": mass(fmu), "inputs": ["mass.x1"], "figures": FIGURES, **options}
    values = given.pop("values", [1.0])
    with pytest.raises(UsageError) as caught, cosim.Function(**given) as function:
        function(values)
    assert words in str(caught.value) and "--" not in str(caught.value)
