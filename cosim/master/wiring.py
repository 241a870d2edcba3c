"""A loaded system as arrays: everything a tick needs, and nothing else.

All numbers of a run live in one flat vector, `signals`, as doubles: one slot for each variable that is
connected or recorded. Inputs are gathered from it, so a connection is an index, a factor and an offset.
Texts live beside it, in `texts`; so do whole numbers, in `exact`, since a double has no 64-bit one.

A group is variables of one component and one type that move in one FMI call; its row in `groups` has the
function's address, the instance, and where references, values and links are. An array moves as a whole, so all its
elements have slots; elements of an input array that are not connected have slots that nothing changes. A component's
row in `components` has its instance, the addresses of its functions, and the range of its slots. Addresses are whole
numbers, so that a compiled loop can call FMUs that were loaded a moment ago.

FMI 2.0 and 3.0 have one table. A function of 3.0 takes the arguments of 2.0 and some more, and all are called with
these: by the calling conventions of 64-bit machines a C function does not see arguments after its last one.
"""
import ctypes
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .declared import Variable
from .description import Description
from .instance import Instance
from .program import (
    BUFFER,
    COMPONENT_COLUMNS,
    COUNT,
    EVENT_COLUMNS,
    FLOAT,
    GROUP_COLUMNS,
    LONGEST_TEXT,
    REAL,
    REFERENCES,
    TEXT,
    VALUES,
)


@dataclass(frozen=True)
class Signal:
    """One column of the results; display = display_factor * value + display_offset, empty if it is not declared."""
    name: str
    unit: str
    description: str
    display_unit: str = ""
    display_factor: float = 1.0
    display_offset: float = 0.0


def signal(name: str, description: Description, variable: Variable) -> Signal:
    """What the FMU declares of `variable`. Offsets of display units do not apply to a difference."""
    unit = description.unit_of(variable)
    display = next((d for d in unit.displays if d.name == variable.display_unit), None) if unit else None
    declares = Signal(name, variable.unit, variable.description)
    return replace(declares, display_unit=display.name, display_factor=display.factor,
                   display_offset=0.0 if variable.relative else display.offset) if display else declares


@dataclass
class Group:
    """One call's variables, by name; `number` is its row in `Wiring.groups`."""
    verb: str
    suffix: str                # what the standard's functions call the type
    kind: int                  # see `program`
    owner: int                 # the component
    names: list[str]
    number: int
    connected: bool            # read because others need it; else only to be recorded
    interpolates: bool = False
    in_events: bool = False    # discrete inputs of a component that has an event mode

    @property
    def real(self) -> bool:
        """Whether its values are real numbers."""
        return self.kind in (REAL, FLOAT)


@dataclass
class Wiring:
    """The tables of a system, see above; columns of `groups` and `components` are named in `program`."""
    columns: list[Signal] = field(default_factory=list)      # what is recorded
    recorded: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))     # slots of the columns
    slots: list[str] = field(default_factory=list)           # component.variable of each slot
    nominal: np.ndarray = field(default_factory=lambda: np.empty(0))                # of each slot
    smooth: np.ndarray = field(default_factory=lambda: np.empty(0, bool))           # a continuous Real
    sources: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))      # slots that are connected
    inputs: list[list[Group]] = field(default_factory=list)  # of each component
    outputs: list[list[Group]] = field(default_factory=list)
    looked_up: list[list[Group]] = field(default_factory=list)  # of each component: read from the table of inputs
    every_group: list[Group] = field(default_factory=list)   # in the order of `groups`
    groups: np.ndarray = field(default_factory=lambda: np.empty((0, GROUP_COLUMNS), np.int64))
    components: np.ndarray = field(default_factory=lambda: np.empty((0, COMPONENT_COLUMNS), np.int64))
    where: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))        # links: slot, factor, offset
    factor: np.ndarray = field(default_factory=lambda: np.empty(0))
    offset: np.ndarray = field(default_factory=lambda: np.empty(0))
    references: np.ndarray = field(default_factory=lambda: np.empty(0, np.uint32))
    buffers: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))      # a word for each link, packed
    slopes: np.ndarray = field(default_factory=lambda: np.empty(0))
    orders: np.ndarray = field(default_factory=lambda: np.empty(0, np.int32))
    signals: np.ndarray = field(default_factory=lambda: np.empty(0))
    exact: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))        # the same of whole numbers, as bits
    before: np.ndarray = field(default_factory=lambda: np.empty(0))                 # the signals one step earlier
    clock: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))             # of each component: now, before
    holder: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))       # component of each slot
    texts: np.ndarray = field(default_factory=lambda: np.empty((0, LONGEST_TEXT), np.uint8))
    states: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))       # saved FMU states
    events: np.ndarray = field(default_factory=lambda: np.empty((0, EVENT_COLUMNS), np.int64))  # see `program`
    offers: np.ndarray = field(default_factory=lambda: np.empty(0, bool))           # components with OFFERs
    held: list[tuple[int, str, int]] = field(default_factory=list)  # component, variable, slot that nothing changes

    def begin(self, instances: list[Instance]) -> None:
        """Before the first tick: the values of slots that nothing changes; inputs of event mode as the FMUs have them,
        so that only a change is one; no answers of a former run. Raises RunError if an FMU refuses."""
        self.events[:] = 0
        for group in self.every_group:
            if group.in_events and group.kind != TEXT:
                instance, row = instances[group.owner], self.groups[group.number].tolist()
                call = f"{instance.standard.PREFIX}Get{group.suffix}"
                instance.check(instance.call(call, ctypes.c_void_p(row[REFERENCES]), ctypes.c_size_t(row[COUNT]),
                                             ctypes.c_void_p(row[BUFFER]), ctypes.c_size_t(row[VALUES])), call)
        for component, name, slot in self.held:
            value: Any = instances[component].held(name)
            if isinstance(value, str):
                self.texts[slot] = np.frombuffer(value.encode()[:LONGEST_TEXT - 1].ljust(LONGEST_TEXT, b"\0"), np.uint8)
            else:
                self.signals[slot] = value
                self.exact[slot] = 0 if isinstance(value, float) else value - 2 ** 64 * (value >= 2 ** 63)
