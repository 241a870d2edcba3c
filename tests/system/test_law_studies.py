"""The scripts that draw and print the resilient law's page: run small, their figures held against single flights."""
import draw_law
import law_table
import matplotlib.image
import numpy as np
import pytest
from evidence import fly, summary
from law_studies import PARTS, independent


@pytest.fixture
def pictures(tmp_path, monkeypatch, native_fmus):
    """Pictures go to a folder of the test's own."""
    monkeypatch.setattr(draw_law, "PICTURES", tmp_path)
    return tmp_path


def drawn(path):
    """Whether a picture is there and shows more than a white page."""
    return np.ptp(matplotlib.image.imread(path)[..., :3]) > 0.5


def test_the_first_picture_is_a_vehicle_that_only_one_law_keeps(pictures):
    said = draw_law.uncertain()
    assert drawn(pictures / "law_uncertain.png")
    assert said["100 ft at s"] <= said["departed at s"] < 15
    assert said["kept"]["survived"] and said["kept"]["h"] < 20


def test_the_maps_count_what_the_flights_show(pictures):
    said = draw_law.maps(count=6)
    assert drawn(pictures / "law_maps.png")
    for name, (law, preset) in draw_law.LAWS.items():
        found = [summary(fly("case1", law, preset, values)) for values in independent(18, 6)]
        kept = [flight.survived for flight in found]
        assert said[name] == {"within": sum(f.survived and f.h < 20 for f in found), "kept": sum(kept), "of": 6}
    assert said["resilient, quiet"]["kept"] == 6


def test_the_ablation_shows_every_part_that_it_is_given(pictures, monkeypatch):
    chosen = {part: PARTS[part] for part in ("nothing", "lift scale")}
    monkeypatch.setattr(draw_law, "PARTS", chosen)
    said = draw_law.ablation(count=2)
    assert drawn(pictures / "law_ablation.png") and said.keys() == chosen.keys()
    assert said["lift scale"]["together_ft"][0] > 10 * said["nothing"]["together_ft"][0]


def test_the_table_prints_a_flown_campaign_and_the_three_largest_errors_are_drawn(pictures, monkeypatch, capsys):
    monkeypatch.setattr(law_table, "OUT", pictures / "campaigns")
    monkeypatch.setitem(law_table.ROWS, "case1", ("case1", {**law_table.ONLY, "runs": 4}))
    law_table.print_campaigns(["case1"], workers=1)
    rows = law_table.flown("case1", workers=1)["resilient"]
    line = capsys.readouterr().out.splitlines()[1].split()
    assert line[:2] == ["case1", "4"] and float(line[2]) == 100 * np.mean(rows["success"].to_pylist())
    monkeypatch.setattr(draw_law, "CASE_1", pictures / "campaigns" / "case1" / "runs.parquet")
    said = draw_law.worst()
    assert drawn(pictures / "law_worst.png")
    largest = sorted(rows["altitude_error_ft.max_abs"].to_pylist())[:0:-1]
    assert [one["error_ft"] for one in said.values()] == pytest.approx(largest, rel=1e-9)
