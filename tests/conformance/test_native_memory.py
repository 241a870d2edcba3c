"""A native controller as a real-time task calls it: what it asks the system for after initialisation."""
import zipfile
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.mark.parametrize("name", ["AhvController", "AhvResilient", "AhvBackstepping"])
def test_steps_allocate_nothing(native_fmus, monkeypatch, name):
    monkeypatch.syspath_prepend(BENCHMARKS)
    from worst_step import measure

    found = measure(name, 2000)
    assert (found["allocations_before"], found["allocations_after"]) == (1, 0)
    assert 0 < found["median_us"] <= found["p99_99_us"] <= found["max_us"]
    with zipfile.ZipFile(native_fmus[name]) as archive:
        library = archive.read(f"binaries/linux64/{name}.so")
        model = archive.read("sources/model.c").decode()
        wrapper = [name for name in archive.namelist() if name.startswith("sources/") and name.endswith(".c")]
        sources = "".join(archive.read(name).decode() for name in wrapper)
    # FMI 3.0 gives an FMU no callback to allocate with: the instance and saved states are made by calloc.
    assert b"malloc" not in library and sources.count("calloc") == 1
    assert "for (" not in model and "while" not in model   # the same operations in every step
