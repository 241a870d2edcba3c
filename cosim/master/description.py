"""modelDescription.xml as plain data: the one reading of it, for what flies an FMU and for what checks one.

It is tolerant, so that rules can judge what is there: `declared` has what is said of variables and types. `read` is for
who needs one that can be used. FMI 3.0 is read in the words of 2.0: what it says by value reference (the state
of a derivative, the model structure) is said here by index. FMI 1.0 is read as far as `cosim.info` shows it.
"""
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from math import prod
from pathlib import Path

from lxml import etree

from .declared import SimpleType, Unknown, Variable, integer, is_true
from .quantities import Unit, unit
from .xml_file import NotXml, root_of

BASE_TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
LARGEST_ARRAY = 1_000_000  # elements
UNKNOWNS = {"Outputs": "Output", "Derivatives": "ContinuousStateDerivative", "InitialUnknowns": "InitialUnknown"}
CLAIMS = {"canGetAndSetFMUstate": "canGetAndSetFMUState", "canSerializeFMUstate": "canSerializeFMUState",  # in FMI 3.0
          "providesDirectionalDerivative": "providesDirectionalDerivatives"}


class Description:
    """The whole modelDescription.xml."""

    def __init__(self, root: etree._Element):
        self.root = root
        self.attributes: dict[str, str] = attributes_of(root)
        self.version = self.attributes.get("fmiVersion", "").strip()
        self.flat = self.version.startswith("3.")  # <Float64 name= ...> instead of <ScalarVariable name= ...><Real/>
        self.co_simulation = self.attributes_at("CoSimulation")
        self.model_exchange = self.attributes_at("ModelExchange")
        self.experiment = self.attributes_at("DefaultExperiment") or {}
        self.types = list(self.read_types())
        self.variables = list(self.read_variables())
        if self.flat:
            self.elements = self.root.findall("ModelVariables/*")
            self.index = {v.reference: v.index for v in reversed(self.variables)}
            self.variables = [self.in_words_of_2(v) for v in self.variables]
        self.outputs = self.read_unknowns("Outputs")
        self.derivatives = self.read_unknowns("Derivatives")
        self.initial_unknowns = self.read_unknowns("InitialUnknowns")

    def attributes_at(self, tag: str) -> dict[str, str] | None:
        """The attributes of the first element `tag`; None where there is none."""
        element = self.root.find(tag)
        return None if element is None else attributes_of(element)

    def read_types(self) -> Iterator[SimpleType]:
        """The types of `<TypeDefinitions>`."""
        if self.flat:  # <Float64Type name= ...>
            for element in self.root.iterfind("TypeDefinitions/*"):
                yield simple_type(element.get("name", ""), element)
        for tag in ("SimpleType", "Type"):  # the latter in FMI 1.0
            for element in self.root.iterfind(f"TypeDefinitions/{tag}"):
                for child in child_elements(element):
                    yield simple_type(element.get("name", ""), child)
                    break

    def read_variables(self) -> Iterator[Variable]:
        """The variables of `<ModelVariables>`, with their declared types."""
        by_name = {known.name: known for known in reversed(self.types)}  # the first of a name counts
        for index, element in enumerate(
                self.root.iterfind(f"ModelVariables/{'*' if self.flat else 'ScalarVariable'}"), 1):
            typed = element if self.flat else next((c for c in child_elements(element) if c.tag in BASE_TYPES), None)
            own = {} if typed is None else attributes_of(typed)
            kind = "" if typed is None else str(typed.tag)
            if self.flat and (start := element.find("Start")) is not None:
                own["start"] = start.get("value", "")
            yield Variable(index, adapted(self.version, kind, attributes_of(element)), kind, own,
                           by_name.get(own.get("declaredType", "")))

    def in_words_of_2(self, v: Variable) -> Variable:
        """A variable of FMI 3.0 with its shape and start values if it is an array, and the index of its state."""
        element = self.elements[v.index - 1]
        own, dimensions = dict(v.own), element.findall("Dimension")
        if "derivative" in own:
            own["derivative"] = str(self.index_of(own["derivative"]))
        if not dimensions:
            return replace(v, own=own)
        sizes = []
        for dimension in dimensions:
            of = self.variable(self.index_of(dimension.get("valueReference")))
            sizes.append(integer(dimension.get("start") if of is None else of.start) or 0)
        texts = [start.get("value", "") for start in element.iterfind("Start")]
        return replace(v, own=own, shape=tuple(max(0, n) for n in sizes), starts=texts or own.get("start", "").split())

    def index_of(self, reference: str | None) -> int:
        """The index of the variable with this value reference (FMI 3.0); 0, which is no valid index, if there is none.
        """
        return self.index.get(integer(reference), 0)

    @cached_property
    def aliases(self) -> list[Variable]:
        """Further names of variables (FMI 3.0, `<Alias>`): to be looked at only, as local variables are."""
        return [replace(v, attributes={**v.attributes, "causality": "local", "description": "", **attributes_of(alias)},
                        own={**v.own, **attributes_of(alias)})
                for v in self.variables for alias in self.elements[v.index - 1].iterfind("Alias")
                ] if self.flat else []

    def read_unknowns(self, tag: str) -> list[Unknown]:
        """The entries of one list of `<ModelStructure>`."""
        if self.flat:
            return [Unknown(self.index_of(element.get("valueReference")),
                            None if (words := element.get("dependencies")) is None
                            else [self.index_of(word) for word in words.split()], kinds_of(element))
                    for element in self.root.iterfind(f"ModelStructure/{UNKNOWNS[tag]}")]
        return [Unknown(integer(element.get("index")), indices(element.get("dependencies")), kinds_of(element))
                for element in self.root.iterfind(f"ModelStructure/{tag}/Unknown")]

    def variable(self, index: int | None) -> Variable | None:
        """The variable with this one-based index, or None when there is none."""
        return self.variables[index - 1] if index is not None and 1 <= index <= len(self.variables) else None

    @cached_property
    def states(self) -> set[int]:
        """Indices of the exposed continuous states: what the variables in `<Derivatives>` are derivatives of."""
        listed = (self.variable(unknown.index) for unknown in self.derivatives)
        return {v.derivative for v in listed if v is not None and v.derivative is not None}

    @cached_property
    def structure(self) -> list[tuple[str, Unknown]]:
        """All entries of `<ModelStructure>` with the name of the list that they are in."""
        lists = {"Outputs": self.outputs, "Derivatives": self.derivatives, "InitialUnknowns": self.initial_unknowns}
        return [(tag, unknown) for tag, unknowns in lists.items() for unknown in unknowns]

    @cached_property
    def units(self) -> dict[str, Unit]:
        """The units of `<UnitDefinitions>` by name (2.2.2); the first of a name counts."""
        found: dict[str, Unit] = {}
        for element in self.root.iterfind("UnitDefinitions/Unit"):
            name, base = element.get("name", ""), element.find("BaseUnit")
            displays = [attributes_of(display) for display in element.iterfind("DisplayUnit")
                        if not is_true(display.get("inverse"))]  # FMI 3.0: not proportional
            found.setdefault(name, unit(name, None if base is None else attributes_of(base), displays))
        return found

    def unit_of(self, variable: Variable) -> Unit | None:
        """The unit of a variable, by its name alone where it is not defined; None without one."""
        return self.units.get(variable.unit, Unit(variable.unit)) if variable.unit else None

    def claims(self, flag: str, exchange: bool = False) -> bool:
        """True when the CoSimulation element, or with `exchange` ModelExchange, sets this capability flag (4.3.1)."""
        element = self.model_exchange if exchange else self.co_simulation
        return is_true((element or {}).get(CLAIMS.get(flag, flag) if self.flat else flag))


def read(folder: Path) -> Description:
    """The description of the FMU unpacked in `folder`. Raises ValueError if it is not there or cannot be used."""
    file = folder / "modelDescription.xml"
    if not file.is_file():
        raise ValueError("it has no modelDescription.xml")
    return usable(file.read_bytes())


def usable(xml: bytes) -> Description:
    """The description `xml`, which can be used.

    Raises ValueError, a sentence without its full stop, for one that cannot: no XML, or a variable without a name, a
    type, a value reference or a definition of its declared type.
    """
    try:
        root = root_of(xml)
    except NotXml as error:
        raise ValueError(f"modelDescription.xml is not well-formed XML ({error})") from None
    description = Description(root)
    if root.tag != "fmiModelDescription" or not description.version:
        raise ValueError("modelDescription.xml is not a description of an FMU")
    for v in description.variables:
        if not v.name or not v.type or v.reference is None:
            raise ValueError(f"its variable {v.name or v.index} has no name, no type or no value reference")
        if "declaredType" in v.own and v.declared is None:
            raise ValueError(f"its variable {v.name} has the declaredType {v.own['declaredType']}, which is not there")
        if v.shape and prod(v.shape) > LARGEST_ARRAY:
            raise ValueError(f"its variable {v.name} is an array of {prod(v.shape)} elements; at most {LARGEST_ARRAY} "
                             f"are read")
    for tag, unknown in description.structure:
        for index in (unknown.index, *(unknown.dependencies or [])):
            if description.variable(index) is None:
                if description.flat:
                    raise ValueError(f"its model structure ({UNKNOWNS[tag]}) refers to a value reference that no "
                                     f"variable has")
                raise ValueError(f"an Unknown of its {tag} refers to the variable {index}, which is not there")
    return description


def adapted(version: str, kind: str, attributes: dict[str, str]) -> dict[str, str]:
    """A variable's attributes in the words and with the defaults of FMI 2.0, where another version has others."""
    if version.startswith("1.") and attributes.get("variability") == "parameter":
        return {**attributes, "causality": "parameter", "variability": "fixed"}
    if version.startswith("1.") and attributes.get("causality") == "internal":
        return {**attributes, "causality": "local"}
    if version.startswith("3."):
        fixed = attributes.get("causality", "").lower().endswith("parameter")
        default = "fixed" if fixed else "continuous" if kind.startswith("Float") else "discrete"
        return {"variability": default, **attributes}
    return attributes


def simple_type(name: str, element: etree._Element) -> SimpleType:
    """A type from the element that has its attributes: Real, or RealType and Float64Type in other versions of FMI."""
    return SimpleType(name, str(element.tag).removesuffix("Type"), attributes_of(element),
                      [attributes_of(item) for item in element.iterfind("Item")])


def indices(text: str | None) -> list[int] | None:
    """A list of indices; what is no integer becomes 0, which is no valid index."""
    return None if text is None else [integer(word) or 0 for word in text.split()]


def kinds_of(element: etree._Element) -> list[str] | None:
    """The words of dependenciesKind; None where it is absent."""
    kinds = element.get("dependenciesKind")
    return None if kinds is None else kinds.split()


def child_elements(parent: etree._Element) -> Iterator[etree._Element]:
    """The children that are elements, not comments."""
    yield from parent.iterchildren(tag=etree.Element)


def attributes_of(element: etree._Element) -> dict[str, str]:
    """The attributes as plain text."""
    return {str(key): str(value) for key, value in element.attrib.items()}
