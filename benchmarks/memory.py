"""Memory of a run whose recording streams to disk, over the run's length: `ahv bench memory`.

Each length is a process of its own; all outputs of two small FMUs (10 columns) are streamed.
"""
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

TICKS = (10**5, 10**6, 10**7)


def fly_once(ticks: int, folder: Path) -> dict[str, float]:
    import pyarrow.parquet
    import small

    from cosim.master.fly import fly

    system = small.pair(small.build(folder), a22=0.0)
    flight = fly(system, 0.001, ticks * 0.001, "jacobi", stream=folder / "signals.parquet")
    assert flight.finished, flight.message
    rows = pyarrow.parquet.ParquetFile(folder / "signals.parquet").metadata.num_rows
    return {"ticks": ticks, "rows_on_disk": rows, "rows_in_memory": len(flight.time), "wall_s": flight.wall_s,
            "megabytes_on_disk": (folder / "signals.parquet").stat().st_size / 1e6,
            "peak_megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3}


def main() -> None:
    if len(sys.argv) > 2 and sys.argv[1] == "--one":
        with tempfile.TemporaryDirectory() as folder:
            print(json.dumps(fly_once(int(sys.argv[2]), Path(folder))))
        return
    rows = [json.loads(subprocess.run([sys.executable, __file__, "--one", str(ticks)], check=True, text=True,
                                      capture_output=True).stdout) for ticks in TICKS]
    if "--json" in sys.argv:
        print(json.dumps({"memory": rows}))
        return
    for row in rows:
        print("  ".join(f"{key} {value:g}" for key, value in row.items()))


if __name__ == "__main__":
    main()
