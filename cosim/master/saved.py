"""A whole run saved in a file, to go on from later: the states of all FMUs, and what the master knows beside them.

The file is a numpy archive (.npz) without objects: `about` is JSON, `state_0` ... are the FMUs' states as bytes,
`before` and `clock` what `hold=linear` and `multi-rate` need of the last step.
"""
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError
from .whole_file import whole

if TYPE_CHECKING:
    from .loaded import Master


@dataclass(frozen=True)
class Saved:
    """A run that was saved at `time` (s), `ticks` steps of `step` after `start`."""
    path: Path
    start: float
    step: float
    ticks: int
    time: float
    components: dict[str, str]     # name -> SHA-256 of its FMU
    connections: list[list[Any]]
    slots: list[str]               # of `before`
    before: np.ndarray
    clock: np.ndarray
    states: list[bytes]

    def put(self, master: "Master") -> None:
        """Have the FMUs of an initialised system go on from here.

        Raises UsageError if the system has other FMUs or connections, RunError if an FMU refuses.
        """
        for word, mine, others in (("FMUs", self.components, components(master)),
                                   ("connections", self.connections, connections(master))):
            if mine != others:
                raise UsageError(f"{self.path} was saved by a system of other {word}.")
        for instance, state in zip(master.instances, self.states):
            instance.restore(state)
        w = master.wiring
        master.show(self.time)
        known = dict(zip(self.slots, self.before.tolist()))
        w.before[:] = [known.get(name, now) for name, now in zip(w.slots, w.signals.tolist())]
        w.clock[:] = self.clock
        w.begin(master.instances)


def components(master: "Master") -> dict[str, str]:
    """Component -> SHA-256 of its FMU."""
    return {c.name: master.files[c.name].sha256 for c in master.system.components}


def connections(master: "Master") -> list[list[Any]]:
    """The connections as JSON has them, in one order."""
    return sorted([k.target, k.source, k.factor, k.offset] for k in master.targets.values())


def need_bytes(master: "Master") -> None:
    """Raises UsageError, naming the components, if some cannot give their states as bytes."""
    lacking = [i.name for i in master.instances if not i.claims("canSerializeFMUstate")]
    if lacking:
        raise UsageError(f"A run is saved and restored by the states of its FMUs, and {', '.join(lacking)} cannot give "
                         f"one: the FMU does not claim canSerializeFMUstate.")


def save(path: Path, master: "Master", start: float, step: float, ticks: int, time: float) -> None:
    """Write the file `path`: the run is at `time` (s), `ticks` steps of `step` after `start`.

    Raises RunError if an FMU refuses, or the file cannot be written.
    """
    w = master.wiring
    about = {"start": start, "step": step, "ticks": ticks, "time": time, "components": components(master),
             "connections": connections(master), "slots": w.slots}
    states: dict[str, Any] = {f"state_{i}": np.frombuffer(instance.saved(), np.uint8)
                              for i, instance in enumerate(master.instances)}
    with whole(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, about=np.array(json.dumps(about)), before=w.before, clock=w.clock, **states)


def load(path: Path) -> Saved:
    """What `save` has written. Raises UsageError if the file is missing, or is none of these."""
    if not path.is_file():
        raise UsageError(f"There is no file {path}.")
    try:
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            states = [file[f"state_{i}"].tobytes() for i in range(len(about["components"]))]
            return Saved(path, before=file["before"], clock=file["clock"], states=states, **about)
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
        raise UsageError(f"{path} is no run that was saved here.") from None
