"""modelDescription.xml as plain data, read tolerantly: attributes stay the text that is there, so rules can judge it.

The defaults are those of FMI 2.0.x section 2.2.7: causality "local", variability "continuous", and the table that gives
`initial` when it is absent.
"""
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from lxml import etree

BASE_TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")

# Section 2.2.7, the table of `initial`: (variability, causality) -> allowed values, the default first.
EXACT = ("exact",)
CALCULATED = ("calculated", "approx")
ANY = ("calculated", "exact", "approx")
INITIAL: dict[tuple[str, str], tuple[str, ...]] = {
    ("constant", "output"): EXACT,
    ("constant", "local"): EXACT,
    ("fixed", "parameter"): EXACT,
    ("tunable", "parameter"): EXACT,
    ("fixed", "calculatedParameter"): CALCULATED,
    ("tunable", "calculatedParameter"): CALCULATED,
    ("fixed", "local"): CALCULATED,
    ("tunable", "local"): CALCULATED,
    ("discrete", "output"): ANY,
    ("continuous", "output"): ANY,
    ("discrete", "local"): ANY,
    ("continuous", "local"): ANY,
    # For these `initial` must be absent.
    ("discrete", "input"): (),
    ("continuous", "input"): (),
    ("continuous", "independent"): (),
}
CAUSALITIES = frozenset(causality for _, causality in INITIAL)
VARIABILITIES = frozenset(variability for variability, _ in INITIAL)


@dataclass
class SimpleType:
    """A `<SimpleType>` of `<TypeDefinitions>` (2.2.3): `kind` is Real, Integer ..., `attributes` are that element's."""
    name: str
    kind: str
    attributes: dict[str, str]
    items: list[dict[str, str]] = field(default_factory=list)


@dataclass
class Variable:
    """A `<ScalarVariable>` (2.2.7); `own` are the attributes of its Real, Integer, ... element."""
    index: int
    attributes: dict[str, str]
    kind: str
    own: dict[str, str]
    declared: SimpleType | None = None

    @property
    def name(self) -> str:
        """The name; empty where there is none."""
        return self.attributes.get("name", "")

    @property
    def reference(self) -> int | None:
        """valueReference, if it is a number."""
        return integer(self.attributes.get("valueReference"))

    @property
    def causality(self) -> str:
        """As given, or else the default."""
        return self.attributes.get("causality", "local")

    @property
    def variability(self) -> str:
        """As given, or else the default."""
        return self.attributes.get("variability", "continuous")

    @property
    def initial(self) -> str | None:
        """`initial` as given, or else the default of the table in section 2.2.7."""
        allowed = INITIAL.get((self.variability, self.causality), ())
        return self.attributes.get("initial", allowed[0] if allowed else None)

    @property
    def start(self) -> str | None:
        """The start value as text."""
        return self.own.get("start")

    @property
    def derivative(self) -> int | None:
        """The index of the variable whose derivative this one is."""
        return integer(self.own.get("derivative"))

    @property
    def base(self) -> str:
        """The type by which the C functions know the variable: an Enumeration is read with fmi2GetInteger."""
        return "Integer" if self.kind == "Enumeration" else self.kind

    def resolved(self, attribute: str) -> str | None:
        """The variable's own attribute, or else the one of its declared type (2.2.7, `declaredType`)."""
        inherited = self.declared.attributes.get(attribute) if self.declared else None
        return self.own.get(attribute, inherited)


@dataclass
class Unknown:
    """An `<Unknown>` of `<ModelStructure>` (2.2.8); `None` means that the attribute is absent."""
    index: int | None
    dependencies: list[int] | None
    kinds: list[str] | None


class Description:
    """The whole modelDescription.xml."""

    def __init__(self, root: etree._Element):
        self.root = root
        self.attributes: dict[str, str] = attributes_of(root)
        self.co_simulation = self.attributes_at("CoSimulation")
        self.model_exchange = self.attributes_at("ModelExchange")
        self.types = list(self.read_types())
        self.variables = list(self.read_variables())
        self.outputs = self.read_unknowns("Outputs")
        self.derivatives = self.read_unknowns("Derivatives")
        self.initial_unknowns = self.read_unknowns("InitialUnknowns")

    def attributes_at(self, tag: str) -> dict[str, str] | None:
        """The attributes of the first element `tag`; None where there is none."""
        element = self.root.find(tag)
        return None if element is None else attributes_of(element)

    def read_types(self) -> Iterator[SimpleType]:
        """The types of `<TypeDefinitions>`."""
        for element in self.root.iterfind("TypeDefinitions/SimpleType"):
            for child in child_elements(element):
                items = [attributes_of(item) for item in child.iterfind("Item")]
                yield SimpleType(element.get("name", ""), str(child.tag), attributes_of(child), items)
                break

    def read_variables(self) -> Iterator[Variable]:
        """The variables of `<ModelVariables>`, with their declared types."""
        by_name = {known.name: known for known in reversed(self.types)}  # the first of a name counts
        for index, element in enumerate(self.root.iterfind("ModelVariables/ScalarVariable"), start=1):
            typed = next((child for child in child_elements(element) if child.tag in BASE_TYPES), None)
            own = {} if typed is None else attributes_of(typed)
            kind = "" if typed is None else str(typed.tag)
            yield Variable(index, attributes_of(element), kind, own, by_name.get(own.get("declaredType", "")))

    def read_unknowns(self, tag: str) -> list[Unknown]:
        """The entries of one list of `<ModelStructure>`."""
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

    def claims(self, flag: str) -> bool:
        """True when the CoSimulation element sets this capability flag (4.3.1)."""
        return (self.co_simulation or {}).get(flag, "false").strip() in ("true", "1")


def number(text: str | None) -> float | None:
    """The finite number that an attribute holds, or None."""
    try:
        value = float(text) if text is not None else None
    except ValueError:
        return None
    return value if value is not None and math.isfinite(value) else None


def integer(text: str | None) -> int | None:
    """The integer that an attribute holds, or None."""
    try:
        return int(text) if text is not None else None
    except ValueError:
        return None


def indices(text: str | None) -> list[int] | None:
    """A list of indices; what is no integer becomes 0, which is no valid index."""
    return None if text is None else [integer(word) or 0 for word in text.split()]


def kinds_of(element: etree._Element) -> list[str] | None:
    """The words of dependenciesKind; None where it is absent."""
    kinds = element.get("dependenciesKind")
    return None if kinds is None else kinds.split()


def child_elements(parent: etree._Element) -> Iterator[etree._Element]:
    """The children that are elements, not comments."""
    return parent.iterchildren(tag=etree.Element)


def attributes_of(element: etree._Element) -> dict[str, str]:
    """The attributes as plain text."""
    return {str(key): str(value) for key, value in element.attrib.items()}
