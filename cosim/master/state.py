"""The whole state of a flight between two ticks in a file: every FMU's own state, and the signals between them."""
import io
import json
import zipfile
import zlib
from dataclasses import dataclass, field
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import RunError, UsageError
from .algorithms import Method
from .algorithms.base import Even
from .loaded import Master
from .whole_file import whole

if TYPE_CHECKING:
    from .flight import Flight

KIND = "state of a flight of ahv 1"  # the version of the file


@dataclass(frozen=True)
class State:
    """A state as its file has it; `start` (s), `step` (s) and `tick` are those of the flight that it was saved of."""
    path: Path
    start: float
    step: float
    tick: int
    algorithm: str
    components: dict[str, str]              # name -> SHA-256 of the FMU
    arrays: dict[str, np.ndarray] = field(repr=False)

    @property
    def time(self) -> float:
        """When it was saved, s."""
        return self.start + self.tick * self.step

    def check(self, step: float, algorithm: str, ticks: int) -> None:
        """Raises UsageError unless a flight of `ticks` steps of `step` (s) can go on from here."""
        if step != self.step:
            raise UsageError(f"--step {step:g} is not that of {self.path}, which is {self.step:g} s: a flight goes on "
                             f"in the steps in which it began.")
        if algorithm != self.algorithm:
            raise UsageError(f"--algorithm {algorithm} is not that of {self.path}, which is {self.algorithm}.")
        if ticks <= self.tick:
            raise UsageError(f"--stop {self.start + ticks * step:g} s must be after {self.time:g} s, at which "
                             f"{self.path} was saved.")

    def into(self, master: Master) -> None:
        """Put a master that is initialised into this state.

        Raises UsageError if its FMUs are others, RunError if one refuses.
        """
        mine = fingerprints(master)
        for name in {**self.components, **mine}:
            if self.components.get(name) != mine.get(name):
                raise UsageError(f"{name} is not the same FMU in the system and in {self.path}: a flight goes on with "
                                 f"the FMUs with which it began.")
        w, arrays = master.wiring, self.arrays
        for i, instance in enumerate(master.instances):
            instance.restore(arrays[f"fmu_{i}"].tobytes())
        w.begin(master.instances)        # inputs of event mode are as the FMUs have them
        w.clock[:] = arrays["clock"]
        master.read_all(self.time)       # of what this flight records and the other did not
        w.before[:] = w.signals
        saved = {name: i for i, name in enumerate(json.loads(arrays["slots"].tobytes()))}
        here = [s for s, name in enumerate(w.slots) if name in saved]
        there = [saved[w.slots[s]] for s in here]
        for place, name in ((w.signals, "signals"), (w.exact, "exact"), (w.before, "before")):
            place[here] = arrays[name][there]


def fingerprints(master: Master) -> dict[str, str]:
    """Component -> SHA-256 of its FMU."""
    return {c.name: master.files[c.name].sha256 for c in master.system.components}


def need_even(chosen: Method) -> None:
    """Raises UsageError for an algorithm whose steps are not equally long."""
    if not issubclass(chosen.algorithm, Even):
        raise UsageError(f"--save and --restore need steps that are equally long; those of {chosen.word} are not.")


def need_serialised(master: Master) -> None:
    """Raises UsageError, naming the components, if some cannot write down their state."""
    lacking = [i.name for i in master.instances if not i.claims("canSerializeFMUstate")]
    if lacking:
        raise UsageError(f"--save and --restore need FMUs that write down their state, and {', '.join(lacking)} "
                         f"cannot: the FMU does not claim canSerializeFMUstate.")


def write_state(path: Path, master: Master, start: float, step: float, algorithm: str, tick: int) -> None:
    """Write the state after `tick` steps of `step` (s) from `start` (s) to `path`.

    Raises RunError if an FMU refuses or the file cannot be written.
    """
    w = master.wiring
    about = {"kind": KIND, "start": start, "step": step, "tick": tick, "algorithm": algorithm,
             "components": fingerprints(master)}
    arrays: dict[str, Any] = {"about": as_bytes(json.dumps(about)), "slots": as_bytes(json.dumps(w.slots)),
                              "signals": w.signals, "exact": w.exact, "before": w.before, "clock": w.clock}
    for i, instance in enumerate(master.instances):
        arrays[f"fmu_{i}"] = np.frombuffer(instance.saved(), np.uint8)
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **arrays)
    with whole(path) as partial:
        partial.write_bytes(content.getvalue())


def keep_state(path: Path, master: Master, flight: "Flight", start: float, step: float, algorithm: str, first: int
               ) -> None:
    """Write the state at the end of a flight, which has failed if it finds no room or an FMU refuses."""
    try:
        write_state(path, master, start, step, algorithm, first + flight.ticks)
    except RunError as error:
        flight.fail(str(error))


def as_bytes(text: str) -> np.ndarray:
    """A text as an array of bytes."""
    return np.frombuffer(text.encode(), np.uint8)


def read_state(path: Path) -> State:
    """The state in a file that --save wrote. Raises UsageError, one sentence, for a file that is none."""
    if not isfile(path):
        raise UsageError(f"There is no state {path}.")
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        about = json.loads(arrays["about"].tobytes())
        if about["kind"] != KIND:
            raise ValueError
        slots, fmus = json.loads(arrays["slots"].tobytes()), len(about["components"])
        shapes = {name: (len(slots),) for name in ("signals", "exact", "before")} | {"clock": (fmus, 2)}
        fitting = (all(arrays[name].shape == shape and arrays[name].dtype.kind in "biuf"
                       for name, shape in shapes.items())
                   and all(arrays[f"fmu_{i}"].dtype == np.uint8 for i in range(fmus))
                   and type(about["tick"]) is int and 0 <= about["tick"] < 1 << 62)
        if not fitting:
            raise ValueError
        return State(path, float(about["start"]), float(about["step"]), about["tick"], str(about["algorithm"]),
                     dict(about["components"]), arrays)
    except (ValueError, LookupError, TypeError, AttributeError, EOFError, OSError, ArithmeticError, MemoryError,
            RuntimeError, zlib.error, zipfile.BadZipFile):  # whatever a file that is damaged on purpose leads to
        raise UsageError(f"{path} is no state that `ahv simulate --save` wrote.") from None
