"""Time per tick of FMI 2.0 and FMI 3.0 in our master, in one run: `ahv bench versions [--json]`.

The same two oscillators, which push each other: both of FMI 2.0, one of each, both of FMI 3.0, and both of FMI 3.0 with
event mode (used, without an event). One process, rounds in turn, Jacobi, all connected outputs recorded. CPU time of
4,096 ticks in one call; the median and the least over the rounds.
"""
import argparse
import json
import tempfile
import time
from pathlib import Path
from statistics import median

import small
import small3

from cosim.master.algorithms import method
from cosim.master.algorithms.base import Experiment
from cosim.master.loaded import Master, open_files
from cosim.master.recording import CHUNK_ROWS, Recorder
from cosim.master.system import System

ROUNDS, STEP = 400, 0.001


class Chunk:
    """A loaded system; `took` is the time (s) of CHUNK_ROWS ticks."""

    def __init__(self, system: System, files: dict):
        names = sorted({c.source for c in system.connections})
        self.master = Master(system, files, names)
        chosen, recorder = method("jacobi"), Recorder(self.master.columns)
        self.ops = chosen.algorithm(self.master, chosen.options, Experiment(0.0, STEP, CHUNK_ROWS, recorder)).ops
        self.master.initialise(0.0, 1e9)
        self.room = recorder.room(CHUNK_ROWS)
        self.ticks = 0

    def took(self) -> float:
        self.master.cursor[:] = 0
        begun = time.process_time_ns()
        status = self.master.attempt(self.ops, self.ticks, CHUNK_ROWS, 0.0, STEP, *self.room, 1)
        took = time.process_time_ns() - begun
        assert status == 0, status
        self.ticks += CHUNK_ROWS
        return took * 1e-9


def measure(rounds: int) -> dict[str, dict[str, float]]:
    """System -> median and least nanoseconds per tick, ratio of the medians to FMI 2.0's."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        old, new, events = small.build(folder), small3.build(folder), small3.build(folder, events=True)
        same = {"a21": -4.0, "a22": -0.3}
        systems = {"FMI 2.0": small.pair(old, **same), "FMI 2.0 and 3.0": small.pair(old, new, **same),
                   "FMI 3.0": small.pair(new, **same), "FMI 3.0, event mode": small.pair(events, **same)}
        found: dict[str, list[float]] = {name: [] for name in systems}
        opened = [open_files(system) for system in systems.values()]
        try:
            chunks = [Chunk(system, files.__enter__()) for system, files in zip(systems.values(), opened)]
            for _ in range(rounds):
                for name, chunk in zip(systems, chunks):
                    found[name].append(1e9 * chunk.took() / CHUNK_ROWS)
            for chunk in chunks:
                chunk.master.close()
        finally:
            for files in opened:
                files.__exit__(None, None, None)
    own = median(found["FMI 2.0"])
    return {name: {"ns": median(times), "least_ns": min(times), "ratio": median(times) / own}
            for name, times in found.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--json", action="store_true")
    words = parser.parse_args()
    result = measure(words.rounds)
    if words.json:
        print(json.dumps({"versions": result}))
        return
    print("two small C FMUs       ns per tick   least   times FMI 2.0")
    for name, row in result.items():
        print(f"{name:<20} {row['ns']:13.1f} {row['least_ns']:7.1f} {row['ratio']:15.2f}")


if __name__ == "__main__":
    main()
