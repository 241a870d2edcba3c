"""Campaign files that are wrong, of our scenarios and of any system: one sentence with line and field, exit status 2,
no cluster started, nothing written. (`test_campaign_file` has those of scenarios and dispersions.)"""
import re
import zipfile

import pytest
from places import ROOT

from cosim.campaign import cluster
from cosim.cli.app import done

NATIVE = ROOT / "fmus" / "dist" / "native"
SYSTEM = """\
components: {plant: AhvPlant.fmu, law: AhvController.fmu}
connections: [plant.V -> law.V]
experiment: {stop: 1, step: 0.01}
"""
OURS = """\
name: small
scenario: case1
runs: 8
seed: 3
dispersions:
  plant.mass: {distribution: uniform, low: 290, high: 310}
metrics:
  peak: max(plant.h - controller.h_reference)
success:
  altitude: peak < 20
"""
ANY = OURS.replace("scenario: case1", "system: two.yaml").replace("controller.h_reference", "80000")
MASS, PEAK, GOOD = "{distribution: uniform, low: 290, high: 310}", "max(plant.h - 80000)", "peak < 20"

# kind -> (what of ANY, by what, the sentence from the line on)
BAD = {
    # own metrics
    "an unknown signal": (PEAK, "max(plant.hh)", "line 8: metrics.peak: 'max(plant.hh)': there is no metric or signal "
                          "plant.hh; did you mean plant.h?"),
    "an unknown component": (PEAK, "max(plnt.h)", "line 8: metrics.peak: 'max(plnt.h)': there is no metric or signal "
                             "plnt.h; did you mean plant.h?"),
    "an unknown function": (PEAK, "maxx(plant.h)", "line 8: metrics.peak: 'maxx(plant.h)': there is no function maxx; "
                            "did you mean max?"),
    "a function of nothing": (PEAK, "rms()", "line 8: metrics.peak: 'rms()': rms takes a signal, not 0: rms()."),
    "too few arguments": (PEAK, "settling(plant.h, 3)", "line 8: metrics.peak: 'settling(plant.h, 3)': settling takes a "
                          "signal, a target and a band, not 2: settling(plant.h, 3)."),
    "too many arguments": (PEAK, "mean(plant.h, plant.V)", "line 8: metrics.peak: 'mean(plant.h, plant.V)': mean takes "
                           "a signal, not 2: mean(plant.h, plant.V)."),
    "a level that is a signal": (PEAK, "time_above(plant.h, plant.V)", "line 8: metrics.peak: 'time_above(plant.h, "
                                 "plant.V)': in time_above(plant.h, plant.V), plant.V is not a number."),
    "a condition for a signal": (PEAK, "mean(plant.h > 3)", "line 8: metrics.peak: 'mean(plant.h > 3)': in mean(plant.h "
                                 "> 3), plant.h > 3 is not a signal."),
    "a number for a condition": (PEAK, "first(3)", "line 8: metrics.peak: 'first(3)': in first(3), 3 is not true or "
                                 "false at each time."),
    "a signal for a metric": (PEAK, "plant.h", "line 8: metrics.peak: 'plant.h' is a signal: say which number of it, "
                              "such as max(plant.h)."),
    "a condition for a metric": (PEAK, "plant.h > 3", "line 8: metrics.peak: 'plant.h > 3' is true or false at each "
                                 "time: say how long it holds, or from when on: time_on(plant.h > 3), first(plant.h > 3)."),
    "a truth for a metric": (PEAK, "max(plant.h) > 3", "line 8: metrics.peak: 'max(plant.h) > 3' is true or false, not "
                             "a number."),
    "a metric of the next metric": (PEAK, "2 * later\n  later: max(plant.h)", "line 8: metrics.peak: '2 * later': there "
                                    "is no metric or signal later;"),
    "a metric of itself": (PEAK, "2 * peak", "line 8: metrics.peak: '2 * peak': there is no metric or signal peak;"),
    "no expression": (PEAK, "max(plant.h", "line 8: metrics.peak: 'max(plant.h' is not an expression."),
    "an element without quotes": (PEAK, "max(plant.x[1])", "line 8: metrics.peak: 'max(plant.x[1])': plant.x[1] is not "
                                  "allowed in an expression; a signal of that name is written in quotes."),
    "an unknown name in quotes": (PEAK, "max(\"plant.x[1]\")", "line 8: metrics.peak: 'max(\"plant.x[1]\")': there is "
                                  "no metric or signal plant.x[1];"),
    "code in a metric": (PEAK, "__import__('os').getpid()", "line 8: metrics.peak: '__import__('os').getpid()': "
                         "__import__('os').getpid() is not allowed in an expression."),
    "an attribute of a number": (PEAK, "max(plant.h).real", "line 8: metrics.peak: 'max(plant.h).real': "
                                 "max(plant.h).real is not allowed in an expression."),
    "a number for a text": (PEAK, "3", "line 8: metrics.peak: Input should be a valid string, not 3."),
    "a long expression": (PEAK, "1 + " * 300 + "1", "line 8: metrics.peak: an expression has at most 1000 characters, "
                          "not 1201."),
    "a deep expression": (PEAK, "-" * 200 + "1", "it is nested more than 100 levels deep."),
    "a number without bounds": (PEAK, "max(plant.h) * 1" + "0" * 400, "is too large a number."),
    "metrics in a list": (f"\n  peak: {PEAK}", " [peak]", "line 7: metrics: Input should be a valid dictionary."),
    "a metric called like a signal": ("peak: max", "plant.h: max", "line 8: metrics.plant.h: "),
    "a metric called like a draw": ("peak: max", "plant.mass: max", "line 8: metrics.plant.mass: "),
    "a metric called like a column": ("peak: max", "status: max", "line 8: metrics.status: "),
    "a metric that is no name": ("peak: max", "a b: max", "line 8: metrics.a b: "),
    # success
    "success of nothing there": (GOOD, "peek < 20", "line 10: success.altitude: 'peek < 20': there is no metric or "
                                 "signal peek; did you mean peak?"),
    "success that is a number": (GOOD, "peak", "line 10: success.altitude: 'peak' is neither true nor false: compare "
                                 "something."),
    "success at each time": (GOOD, "plant.h < 20", "line 10: success.altitude: 'plant.h < 20' is true or false at each "
                             "time: say how long it holds, or from when on: time_on(plant.h < 20), first(plant.h < 20)."),
    "success that is a signal": (GOOD, "plant.h", "line 10: success.altitude: 'plant.h' is a signal: say which number "
                                 "of it, such as max(plant.h)."),
    "success of truth and condition": (GOOD, "peak < 3 and plant.h > 2", "line 10: success.altitude: 'peak < 3 and "
                                       "plant.h > 2': in peak < 3 and plant.h > 2, plant.h > 2 is not true or false."),
    "a truth that is added": (GOOD, "(peak < 3) + 1 < 2", "line 10: success.altitude: '(peak < 3) + 1 < 2': in (peak < "
                              "3) + 1, peak < 3 is not a number."),
    "no success": ("success:\n  altitude: peak < 20\n", "success: {}\n", "line 9: success: "),
    "an unknown metric to rank by": ("runs: 8", "runs: 8\nworst_by: peek", "line 4: worst_by: there is no peek; there are "
                                     "peak"),
    # systems
    "no system at all": ("system: two.yaml\n", "", "line 1: "),
    "both": ("system: two.yaml", "system: two.yaml\nscenario: case1", "either scenario or system is wanted, not both."),
    "a system that is not there": ("two.yaml", "tow.yaml", "line 2: system: There is no system file "),
    "a system of another kind": ("two.yaml", "two.txt", "line 2: system: "),
    "a folder for a system": ("two.yaml", ".", "line 2: system: "),
    "a system that is broken": ("two.yaml", "broken.yaml", "broken.yaml, line 1: components.plant: There is no FMU at "),
    "a law beside a system": ("runs: 8", "runs: 8\ncontrollers: [neural]", "line 4: controllers: this belongs to scenario, "
                              "and the file has system."),
    "a plant beside a system": ("runs: 8", "runs: 8\nplant: ideal", "line 4: plant: this belongs to scenario"),
    "a preset beside a system": ("runs: 8", "runs: 8\npresets: {law: robust}", "line 4: presets: this belongs to scenario"),
    "a flavour beside a system": ("runs: 8", "runs: 8\nflavour: native", "line 4: flavour: this belongs to scenario"),
    "a variable that is not there": ("plant.mass", "plant.maas", "line 6: dispersions.plant.maas: AhvPlant.fmu has no "
                                     "variable maas; did you mean mass?"),
    "a component that is not there": ("plant.mass", "plnt.mass", "line 6: dispersions.plnt.mass: There is no component "
                                      "plnt; there are plant, law."),
    "a draw on a connected input": ("plant.mass", "law.V", "line 6: dispersions.law.V: "),
    "a value that is not there": ("runs: 8", "runs: 8\nset: {plant.maas: 3}", "line 4: set.plant.maas: "),
    "a value that is not allowed": ("runs: 8", "runs: 8\nset: {plant.mass: -3}", "line 4: set.plant.mass: plant.mass = -3"),
    "a draw that is not allowed": ("low: 290", "low: -1", "line 6: dispersions.plant.mass: plant.mass = -1.0 is not "
                                   "allowed: it must be between 0.3 and 300000 slug/ft."),
    "a step that does not fit": ("runs: 8", "runs: 8\nstep: 0.3", "line 4: step: --stop 1 s is not a whole number of "
                                 "communication steps of 0.3 s."),
    "a stop before the start": ("runs: 8", "runs: 8\nstart: 5", "line 4: start: --stop 1 s must be after the "
                                "start at 5 s."),
    "an algorithm that is not there": ("runs: 8", "runs: 8\nalgorithm: magic", "line 4: algorithm: "),
    "a tolerance of nothing": ("runs: 8", "runs: 8\ntolerance: 0", "line 4: tolerance: Input should be greater than 0"),
    "a curve that is not there": ("runs: 8", "runs: 8\nover_time: [plant.hh]", "line 4: over_time.0: there is no signal "
                                  "plant.hh; did you mean plant.h?"),
    # variants
    "variants that are no list": ("runs: 8", "runs: 8\nvariants: {name: a}", "line 4: variants: Input should be a valid "
                                  "list."),
    "a variant without a name": ("runs: 8", "runs: 8\nvariants:\n- set: {plant.mass: 300}", "line 5: variants.0: name is "
                                 "missing."),
    "two variants of one name": ("runs: 8", "runs: 8\nvariants: [{name: a}, {name: a}]", "line 4: variants: two variants "
                                 "are called a: give each a name of its own."),
    "a variant that is a path": ("runs: 8", "runs: 8\nvariants: [{name: ../a}]", "line 4: variants.0.name: "),
    "a field of no variant": ("runs: 8", "runs: 8\nvariants: [{name: a, sett: {}}]", "line 4: variants.0.sett: there is no "
                              "such field."),
    "a variant of a component that is not there": ("runs: 8", "runs: 8\nvariants: [{name: a, fmus: {plnt: b.fmu}}]",
                                                   "line 4: variants.0.fmus.plnt: there is no component plnt; did you "
                                                   "mean plant?"),
    "a variant of a file that is not there": ("runs: 8", "runs: 8\nvariants: [{name: a, fmus: {plant: b.fmu}}]",
                                              "line 4: variants.0.fmus.plant: there is no file b.fmu."),
    "a variant with a value that is not allowed": ("runs: 8", "runs: 8\nvariants: [{name: a, set: {plant.mass: -1}}]",
                                                   "line 4: variants.0.set.plant.mass: plant.mass = -1"),
    "variants beside a scenario": ("system: two.yaml", "scenario: case1\nvariants: [{name: a}]", "line 3: variants: this "
                                   "belongs to system, and the file has scenario."),
    # signals
    "signals that are not there": ("runs: 8", "runs: 8\nsignals: {record: [plant.zeal]}", "line 4: signals.record: "
                                   "plant.zeal fits no numeric variable."),
    "a share of more than all": ("runs: 8", "runs: 8\nsignals: {share: 2}", "line 4: signals.share: Input should be less "
                                 "than or equal to 1, not 2."),
    "no rows": ("runs: 8", "runs: 8\nsignals: {decimate: 0}", "line 4: signals.decimate: Input should be greater than or "
                "equal to 1, not 0."),
    # dispersions
    "an unknown distribution": ("uniform", "unifrom", "line 6: dispersions.plant.mass: there is no distribution unifrom"),
    "a wave on no scenario": (MASS, "{distribution: sinusoid, amplitude: 1, period: 2}", "line 6: dispersions.plant.mass: "),
    "nothing drawn": (f"\n  plant.mass: {MASS}", " {}", "line 5: dispersions: "),
    "a correlation with nothing": ("metrics:", "correlations:\n- {draws: [plant.mass, plant.chord], coefficient: 0.5}\n"
                                   "metrics:", "line 8: correlations.0: plant.chord is not drawn; there are plant.mass."),
}


@pytest.fixture(scope="module")
def slim(tmp_path_factory):
    """A folder with two of our FMUs without their sources, which take longer to unpack than all else."""
    folder = tmp_path_factory.mktemp("slim")
    for name in ("AhvPlant.fmu", "AhvController.fmu"):
        with zipfile.ZipFile(NATIVE / name) as full, zipfile.ZipFile(folder / name, "w") as made:
            for entry in full.namelist():
                if entry == "modelDescription.xml" or entry.startswith("binaries/linux64"):
                    made.writestr(entry, full.read(entry))
    return folder


@pytest.fixture
def refused(tmp_path, slim, capfd, monkeypatch):
    """What `ahv campaign` says of a file with the text ANY, `before` of it replaced by `after`."""
    def started(*_, **__):
        raise AssertionError("a cluster was started")

    def said(text, before="", after=""):
        assert before in text
        (tmp_path / "bad.yaml").write_text(text.replace(before, after, 1))
        (tmp_path / "two.yaml").write_text(SYSTEM)
        (tmp_path / "two.txt").write_text(SYSTEM)
        (tmp_path / "broken.yaml").write_text("components: {plant: nowhere.fmu}\n")
        for fmu in slim.iterdir():
            (tmp_path / fmu.name).symlink_to(fmu)
        there = set(tmp_path.iterdir())
        status = done(["campaign", str(tmp_path / "bad.yaml"), "--out", str(tmp_path / "out")])
        out, error = capfd.readouterr()
        assert status == 2 and not out and set(tmp_path.iterdir()) == there, error
        lines = error.splitlines()
        assert len(lines) == 1 and re.match(r"ahv: \S+/(bad|broken)\.yaml, line \d+: ", lines[0]), error
        assert re.search(r"[^.?!][.?]$", lines[0]), error
        return lines[0]

    monkeypatch.setattr(cluster, "local", started)
    return said


@pytest.mark.parametrize("before,after,sentence", BAD.values(), ids=BAD)
def test_a_wrong_file_is_refused_in_one_sentence_with_line_and_field(before, after, sentence, refused):
    assert sentence in refused(ANY, before, after)


def test_there_are_sixty():
    assert len(BAD) >= 60
