"""A loaded system as arrays: everything a tick needs, and nothing else.

All numbers of a run live in one flat vector, `signals`, as doubles: one slot for each variable that is
connected or recorded. Inputs are gathered from it, so a connection is an index, a factor and an offset.
Texts live beside it, in `texts`.

A group is variables of one component and one type that move in one FMI call; its row in `groups` has the
function's address, the instance, and where references, values and links are. A component's row in `components`
has its instance, the addresses of its functions, and the range of its slots. Addresses are whole numbers, so that a
compiled loop can call FMUs that were loaded a moment ago.
"""
import ctypes
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase

import numpy as np

from ..errors import UsageError
from .declared import Variable
from .description import Description
from .fmu import CALL_SUFFIX, FmuFile
from .instance import Instance
from .program import REAL, TEXT, WHOLE
from .system import Connection, System

KIND = {"Real": REAL, "Integer": WHOLE, "Enumeration": WHOLE, "Boolean": WHOLE, "String": TEXT}
WIDENS = {("Integer", "Real"), ("Enumeration", "Real"), ("Integer", "Enumeration"), ("Enumeration", "Integer")}
LONGEST_TEXT = 4096


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
    suffix: str                # Real, Integer, Boolean or String
    owner: int                 # the component
    names: list[str]
    number: int
    connected: bool            # read because others need it; else only to be recorded
    interpolates: bool = False


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
    every_group: list[Group] = field(default_factory=list)   # in the order of `groups`
    groups: np.ndarray = field(default_factory=lambda: np.empty((0, 11), np.int64))
    components: np.ndarray = field(default_factory=lambda: np.empty((0, 7), np.int64))
    where: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))        # links: slot, factor, offset
    factor: np.ndarray = field(default_factory=lambda: np.empty(0))
    offset: np.ndarray = field(default_factory=lambda: np.empty(0))
    references: np.ndarray = field(default_factory=lambda: np.empty(0, np.uint32))
    reals: np.ndarray = field(default_factory=lambda: np.empty(0))                  # call buffers
    wholes: np.ndarray = field(default_factory=lambda: np.empty(0, np.int32))
    pointers: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    slopes: np.ndarray = field(default_factory=lambda: np.empty(0))
    orders: np.ndarray = field(default_factory=lambda: np.empty(0, np.int32))
    signals: np.ndarray = field(default_factory=lambda: np.empty(0))
    before: np.ndarray = field(default_factory=lambda: np.empty(0))                 # the signals one step earlier
    clock: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))             # of each component: now, before
    holder: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))       # component of each slot
    texts: np.ndarray = field(default_factory=lambda: np.empty((0, LONGEST_TEXT), np.uint8))
    states: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))       # saved FMU states


def checked_connections(system: System, files: dict[str, FmuFile]) -> dict[str, Connection]:
    """Input `component.variable` -> its connection.

    Raises UsageError naming the connection that does not fit the FMUs.
    """
    targets: dict[str, Connection] = {}
    for link in system.connections:
        source, target = (end.partition(".") for end in (link.source, link.target))
        if source[0] not in files or files[source[0]].variable(source[2]).causality != "output":
            raise UsageError(f"{link.source} is not an output that a connection can start from.")
        if target[0] not in files or files[target[0]].variable(target[2]).causality != "input":
            raise UsageError(f"{link.target} is not an input that a connection can end at.")
        if link.target in targets:
            raise UsageError(f"{link.target} has more than one connection.")
        kinds = files[source[0]].variable(source[2]).type, files[target[0]].variable(target[2]).type
        if kinds[0] != kinds[1] and kinds not in WIDENS:
            raise UsageError(f"{link.source} ({kinds[0]}) cannot be connected to {link.target} ({kinds[1]}).")
        if (link.factor, link.offset) != (1.0, 0.0) and kinds[1] != "Real":
            raise UsageError(f"{link.target} is {kinds[1]}: its connection can have no factor or offset.")
        targets[link.target] = link
    return targets


def recorded_names(system: System, files: dict[str, FmuFile], patterns: list[str] | None) -> set[str]:
    """The variables to record: all numeric outputs, or those whose component.variable fits a pattern.

    Raises UsageError for a pattern that fits nothing.
    """
    known = {f"{c.name}.{v.name}": v for c in system.components for v in files[c.name].description.variables
             if v.type != "String"}
    if patterns is None:
        return {name for name, v in known.items() if v.causality == "output"}
    chosen: set[str] = set()
    for pattern in patterns:
        fits = {name for name in known if name == pattern or fnmatchcase(name, pattern)}
        if not fits:
            raise UsageError(f"--record {pattern} fits no numeric variable of {', '.join(files)}.")
        chosen |= fits
    return chosen


class Wirer:
    """Builds the Wiring of instances: `wire` is called once.

    `targets` has the connection of each connected input, `recorded` the names to record; `apart` puts what is only
    recorded into groups of its own.
    """

    def __init__(self, instances: list[Instance], targets: dict[str, Connection], recorded: set[str],
                 apart: bool):
        self.instances, self.targets, self.recorded, self.apart = instances, targets, recorded, apart
        self.sources = {link.source for link in targets.values()}
        self.wiring = Wiring()
        self.slot: dict[str, int] = {}
        self.text: dict[str, int] = {}
        self.rows: list[list[int]] = []
        self.links: list[tuple[int, float, float]] = []   # slot, factor, offset of each item of each group
        self.references: list[int] = []

    def wire(self) -> Wiring:
        """Give every connected or recorded variable its slot, and fill the tables.

        Raises RunError if an FMU lacks a function that it claims.
        """
        w = self.wiring
        bounds, holder, nominal, smooth = [], [], [], []
        for number, instance in enumerate(self.instances):
            first = len(self.slot)
            for v in instance.file.description.variables:
                name = f"{instance.name}.{v.name}"
                if v.type == "String" and name in self.sources:
                    self.text[name] = len(self.text)
                elif name in self.sources or name in self.recorded:
                    self.slot[name] = len(self.slot)
                    holder.append(number)
                    nominal.append(abs(v.nominal or 1.0))
                    smooth.append(v.type == "Real" and v.variability == "continuous")
                    if name in self.recorded:
                        w.columns.append(signal(name, instance.file.description, v))
            bounds.append((first, len(self.slot)))
        w.slots, w.holder = list(self.slot), np.array(holder, np.int64)
        w.nominal, w.smooth = np.array(nominal, float), np.array(smooth, bool)
        w.recorded = np.array([self.slot[c.name] for c in w.columns], np.int64)
        w.sources = np.array(sorted(self.slot[s] for s in self.sources if s in self.slot), np.int64)
        for number in range(len(self.instances)):
            self.add_groups(number)
        self.allocate(bounds)
        return w

    def add_groups(self, number: int) -> None:
        """Add the groups of the component `number`, inputs and outputs of each type."""
        instance, w = self.instances[number], self.wiring
        full = instance.name + "."
        declared = instance.file.description.variables
        inputs, outputs = [], []
        for suffix in ("Real", "Integer", "Boolean", "String"):
            mine = [v for v in declared if CALL_SUFFIX[v.type] == suffix]
            given = [v.name for v in mine if full + v.name in self.targets]
            read = {v.name: full + v.name in self.sources or not self.apart for v in mine
                    if full + v.name in self.sources | self.recorded}
            if given:
                links = [self.targets[full + n] for n in given]
                slots = self.text if suffix == "String" else self.slot
                inputs.append(self.add_group(number, "Set", suffix, given, True,
                                             [(slots[k.source], k.factor, k.offset) for k in links]))
            for connected in (True, False):
                names = [n for n, needed in read.items() if needed == connected]
                if names:
                    slots = self.text if suffix == "String" else self.slot
                    outputs.append(self.add_group(number, "Get", suffix, names, connected,
                                                  [(slots[full + n], 1.0, 0.0) for n in names]))
        w.inputs.append(inputs)
        w.outputs.append(outputs)

    def add_group(self, number: int, verb: str, suffix: str, names: list[str], connected: bool,
                  links: list[tuple[int, float, float]]) -> Group:
        """Add one group; `links` has slot, factor and offset of each of `names`."""
        instance = self.instances[number]
        group = Group(verb, suffix, number, names, len(self.rows), connected,
                      suffix == "Real" and instance.claims("canInterpolateInputs"))
        self.wiring.every_group.append(group)
        self.rows.append([instance.address(f"fmi2{verb}{suffix}"), instance.pointer, 0, len(names), 0,
                          len(self.links), KIND[suffix], number,
                          instance.address("fmi2SetRealInputDerivatives") if group.interpolates else 0, 0, 0])
        self.links += links
        self.references += [instance.file.variables[n].reference or 0 for n in names]
        return group

    def allocate(self, bounds: list[tuple[int, int]]) -> None:
        """Make the vectors, and write their addresses into the groups."""
        w, length = self.wiring, max(1, len(self.links))
        w.where = np.array([link[0] for link in self.links], np.int64)
        w.factor = np.array([link[1] for link in self.links], float)
        w.offset = np.array([link[2] for link in self.links], float)
        w.references = np.array(self.references, np.uint32)
        w.reals, w.slopes = np.zeros(length), np.zeros(length)
        w.wholes, w.orders = np.zeros(length, np.int32), np.ones(length, np.int32)
        w.pointers = np.zeros(length, np.int64)
        w.signals, w.before = np.zeros(len(self.slot)), np.zeros(len(self.slot))
        w.clock = np.zeros((len(self.instances), 2))
        w.texts = np.zeros((len(self.text), LONGEST_TEXT), np.uint8)
        w.states = np.zeros(len(self.instances), np.int64)
        w.groups = np.array(self.rows, np.int64).reshape(-1, 11)
        buffers = {REAL: w.reals, WHOLE: w.wholes, TEXT: w.pointers}
        for line in w.groups:
            first, buffer = int(line[5]), buffers[int(line[6])]
            line[2] = w.references.ctypes.data + first * w.references.itemsize
            line[4] = buffer.ctypes.data + first * buffer.itemsize
            line[9], line[10] = w.slopes.ctypes.data + first * 8, w.orders.ctypes.data + first * 4
        for group in (g for groups in w.inputs for g in groups if g.suffix == "String"):
            first = int(w.groups[group.number, 5])  # a text input is handed the place where its source is kept
            for i in range(len(group.names)):
                w.pointers[first + i] = w.texts.ctypes.data + LONGEST_TEXT * int(w.where[first + i])
        w.components = np.array([[i.pointer, i.address("fmi2DoStep"), *(
            i.address(f"fmi2{call}FMUstate") if i.claims("canGetAndSetFMUstate") else 0
            for call in ("Get", "Set", "Free")), *span] for i, span in zip(self.instances, bounds)], np.int64)


def strncpy_address() -> int:
    """The address of libc's strncpy. A text output stays the FMU's own, so the loops copy it at once."""
    return ctypes.cast(ctypes.CDLL(None).strncpy, ctypes.c_void_p).value or 0
