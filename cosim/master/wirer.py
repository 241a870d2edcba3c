"""Builds the tables of `wiring` from the instances of a system and its connections."""
import numpy as np

from .declared import Variable
from .instance import Instance
from .look_up import Place
from .program import COMPONENT_COLUMNS, EVENT_COLUMNS, FLAGS, GROUP_COLUMNS, INT64, LONGEST_TEXT, REAL, TEXT
from .system import Connection
from .wiring import Group, Wiring, signal

OF_TABLE = " (table)"  # after the name of an input: its slot


class Wirer:
    """Builds the Wiring of instances: `wire` is called once.

    `targets` has the connection of each connected input, `recorded` the names to record; `apart` puts what is only
    recorded into groups of its own; `place` has the table that feeds inputs, if there is one.
    """

    def __init__(self, instances: list[Instance], targets: dict[str, Connection], recorded: set[str],
                 apart: bool, place: Place | None = None):
        self.instances, self.targets, self.recorded, self.apart = instances, targets, recorded, apart
        self.table = place
        self.columns = {name: i for i, name in enumerate(place.inputs.names)} if place else {}
        self.sources = {link.source for link in targets.values()}
        self.wiring = Wiring()
        self.slot: dict[str, int] = {}
        self.text: dict[str, int] = {}
        self.rows: list[list[int]] = []
        self.links: list[tuple[int, float, float]] = []   # slot, factor, offset of each item of each group
        self.references: list[int] = []
        self.holder: list[int] = []                       # of each slot, as in `Wiring`
        self.nominal: list[float] = []
        self.smooth: list[bool] = []

    def wire(self) -> Wiring:
        """Give every connected or recorded variable its slot, and fill the tables.

        Raises RunError if an FMU lacks a function that it claims.
        """
        w, bounds = self.wiring, []
        for number, instance in enumerate(self.instances):
            file, full, first = instance.file, instance.name + ".", len(self.slot)
            shown = file.together(n for n in file.variables
                                  if full + n in self.sources or full + n in self.recorded)
            for v in map(file.variables.__getitem__, shown):
                self.place(number, v)
                if full + v.name in self.recorded:
                    w.columns.append(signal(full + v.name, file.description, v))
            bounds.append((first, len(self.slot)))
        for number in range(len(self.instances)):
            self.add_groups(number)
        offers = [self.add_offers(number) for number in range(len(self.instances))]
        w.offers = np.array([first < last for first, last in offers], bool)
        w.slots, w.holder = list(self.slot), np.array(self.holder, np.int64)
        w.nominal, w.smooth = np.array(self.nominal, float), np.array(self.smooth, bool)
        w.recorded = np.array([self.slot[c.name] for c in w.columns], np.int64)
        w.sources = np.array(sorted(self.slot[s] for s in self.sources if s in self.slot), np.int64)
        self.allocate(bounds, offers)
        return w

    def place(self, number: int, v: Variable, remark: str = "") -> int:
        """A new slot for a variable of the component `number`, or for a text its place."""
        places = self.text if v.family == "String" else self.slot
        if v.family != "String":
            self.holder.append(number)
            self.nominal.append(abs(v.nominal or 1.0))
            self.smooth.append(v.smooth)
        return places.setdefault(f"{self.instances[number].name}.{v.name}{remark}", len(places))

    def add_groups(self, number: int) -> None:
        """Add the groups of the component `number`, inputs and outputs of each type."""
        instance, w = self.instances[number], self.wiring
        full, file = instance.name + ".", instance.file
        given = file.together(n for n in file.names("input") if full + n in self.targets or full + n in self.columns)
        shown = [n for n in file.variables if full + n in self.slot or full + n in self.text]
        needed = {n for n in shown if full + n in self.sources or not self.apart}
        read = {n: not needed.isdisjoint(file.together([n])) for n in shown}
        w.inputs.append([])
        w.outputs.append([])
        w.looked_up.append(self.add_looked_up(number) if self.table else [])
        for suffix, kind in dict.fromkeys(instance.standard.TYPES.values()):
            mine = [n for n in given if instance.standard.TYPES[file.variables[n].type] == (suffix, kind)
                    and not self.in_events(instance, n)]
            if mine:
                w.inputs[number].append(self.add_group(number, "Set", suffix, kind, mine, True))
            for connected in (True, False):
                mine = [n for n in read if read[n] == connected
                        and instance.standard.TYPES[file.variables[n].type] == (suffix, kind)]
                if mine:
                    w.outputs[number].append(self.add_group(number, "Get", suffix, kind, mine, connected))

    def add_looked_up(self, number: int) -> list[Group]:
        """Add the groups that read the component's inputs from the table, into slots of their own."""
        instance, table, found = self.instances[number], self.table, []
        assert table is not None
        for whole in (False, True):
            names = [n for n in instance.file.names("input") if f"{instance.name}.{n}" in self.columns
                     and (instance.file.variables[n].family != "Real") == whole]
            if not names:
                continue
            group = Group("Get", "Real", INT64 if whole else REAL, number, names, len(self.rows), True)
            slots = [self.place(number, instance.file.variables[n], OF_TABLE) for n in names]
            for slot in slots:
                self.smooth[slot] = False  # known at the start of the step, it has no last slope
            self.wiring.every_group.append(group)
            self.rows.append([table.address(whole), table.pointer, len(self.references), len(names), 0,
                              len(self.links), group.kind, number, 0, 0, 0, len(names)])
            self.links += [(slot, 1.0, 0.0) for slot in slots]
            self.references += [self.columns[f"{instance.name}.{n}"] for n in names]
            found.append(group)
        return found

    def add_offers(self, number: int) -> tuple[int, int]:
        """Add the groups of a component's discrete inputs if these are given in event mode; the range of their rows."""
        instance, first = self.instances[number], len(self.rows)
        full, file = instance.name + ".", instance.file
        given = file.together(n for n in file.names("input")
                              if (full + n in self.targets or full + n in self.columns)
                              and self.in_events(instance, n))
        for suffix, kind in dict.fromkeys(instance.standard.TYPES.values()):
            mine = [n for n in given if instance.standard.TYPES[file.variables[n].type] == (suffix, kind)]
            if mine:
                group = self.add_group(number, "Set", suffix, kind, mine, True)
                group.in_events = True
                self.wiring.inputs[number].append(group)
        return first, len(self.rows)

    @staticmethod
    def in_events(instance: Instance, name: str) -> bool:
        """Whether an input is given in event mode."""
        return instance.uses_events and instance.file.variables[name].variability != "continuous"

    def links_of(self, number: int, names: list[str], text: bool) -> list[tuple[int, float, float]]:
        """Slot, factor and offset of what each of these inputs is given: its source, or what it holds."""
        instance, found = self.instances[number], []
        for name in names:
            link = self.targets.get(f"{instance.name}.{name}")
            if link:
                found.append(((self.text if text else self.slot)[link.source], link.factor, link.offset))
                continue
            if f"{instance.name}.{name}" in self.columns:
                found.append((self.slot[f"{instance.name}.{name}{OF_TABLE}"], 1.0, 0.0))
                continue
            slot = self.place(number, instance.file.variables[name], " (held)")
            self.wiring.held.append((number, name, slot))
            found.append((slot, 1.0, 0.0))
        return found

    def add_group(self, number: int, verb: str, suffix: str, kind: int, names: list[str], connected: bool) -> Group:
        """Add one group."""
        instance = self.instances[number]
        group = Group(verb, suffix, kind, number, names, len(self.rows), connected,
                      suffix == "Real" and instance.claims("canInterpolateInputs"))
        references = instance.file.references(names)
        self.wiring.every_group.append(group)
        self.rows.append([instance.address(verb + suffix), instance.pointer, len(self.references), len(references), 0,
                          len(self.links), kind, number,
                          instance.address("SetRealInputDerivatives") if group.interpolates else 0, 0, 0, len(names)])
        slots = self.text if kind == TEXT else self.slot
        self.links += (self.links_of(number, names, kind == TEXT) if verb == "Set"
                       else [(slots[f"{instance.name}.{n}"], 1.0, 0.0) for n in names])
        self.references += references
        return group

    def allocate(self, bounds: list[tuple[int, int]], offers: list[tuple[int, int]]) -> None:
        """Make the vectors, and write their addresses into the groups."""
        w, length = self.wiring, max(1, len(self.links))
        w.where = np.array([link[0] for link in self.links], np.int64)
        w.factor = np.array([link[1] for link in self.links], float)
        w.offset = np.array([link[2] for link in self.links], float)
        w.references = np.array(self.references, np.uint32)
        w.buffers, w.slopes, w.orders = np.zeros(length, np.int64), np.zeros(length), np.ones(length, np.int32)
        w.signals, w.before = np.zeros(len(self.slot)), np.zeros(len(self.slot))
        w.exact = np.zeros(len(self.slot), np.int64)
        w.clock = np.zeros((len(self.instances), 2))
        w.texts = np.zeros((len(self.text), LONGEST_TEXT), np.uint8)
        w.states = np.zeros(len(self.instances), np.int64)
        w.events = np.zeros((len(self.instances), EVENT_COLUMNS), np.int64)
        w.groups = np.array(self.rows, np.int64).reshape(-1, GROUP_COLUMNS)
        for line in w.groups:
            first = int(line[5])
            line[2] = w.references.ctypes.data + int(line[2]) * w.references.itemsize
            line[4] = w.buffers.ctypes.data + first * 8
            line[9], line[10] = w.slopes.ctypes.data + first * 8, w.orders.ctypes.data + first * 4
        for group in (g for groups in w.inputs for g in groups if g.kind == TEXT):
            first = int(w.groups[group.number, 5])  # a text input is handed the place where its source is kept
            for i in range(len(group.names)):
                w.buffers[first + i] = w.texts.ctypes.data + LONGEST_TEXT * int(w.where[first + i])
        w.components = np.array([self.component(i, *bounds[i], *offers[i]) for i in range(len(self.instances))],
                                np.int64).reshape(-1, COMPONENT_COLUMNS)
        for instance, row in zip(self.instances, w.events):
            instance.events = row

    def component(self, number: int, slots_from: int, slots_to: int, offers_from: int, offers_to: int) -> list[int]:
        """The row of a component, see `program`."""
        instance = self.instances[number]
        saves = instance.claims("canGetAndSetFMUstate")
        states = [instance.address(verb + instance.standard.STATE) if saves else 0 for verb in ("Get", "Set", "Free")]
        enter, update, leave = (instance.address(call) if instance.uses_events else 0
                                for call in ("EnterEventMode", "UpdateDiscreteStates", "EnterStepMode"))
        answers = self.wiring.events[number].ctypes.data + 8 * FLAGS
        return [instance.pointer, instance.address("DoStep"), *states, slots_from, slots_to, enter, update, leave,
                answers, offers_from, offers_to]
