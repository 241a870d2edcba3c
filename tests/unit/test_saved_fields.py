"""Names of fields in a .mat file: all that was found is there."""
from cosim.analysis.save import fields


def test_names_that_become_alike_stay_apart():
    long = "x" * 70
    found = fields({"b.c": 1.0, "b_c": 2.0, "b c": 3.0, f"{long}1": 4.0, f"{long}2": 5.0})
    assert sorted(found.values()) == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert [name for name in found if len(name) < 60] == ["b_c", "b_c_2", "b_c_3"]
    assert all(len(name) <= 62 for name in found)
