"""What modelDescription.xml says of one variable, of one type: attributes as text, read tolerantly.

The defaults are those of FMI 2.0.x section 2.2.7: causality "local", variability "continuous", and the table that gives
`initial` when it is absent. What a variable leaves out is its declared type's.
"""
import math
from dataclasses import dataclass, field, replace
from itertools import product

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
# What the types of both versions of FMI are to those who connect, set and show variables.
FAMILIES = {"Real": "Real", "Float32": "Real", "Float64": "Real", "Integer": "Integer",
            **{f"{sign}Int{bits}": "Integer" for sign in ("", "U") for bits in (8, 16, 32, 64)}}
NUMERIC = ("Real", "Integer", "Enumeration", "Boolean")
CAUSALITIES = frozenset(causality for _, causality in INITIAL)
VARIABILITIES = frozenset(variability for variability, _ in INITIAL)


@dataclass
class SimpleType:
    """A type of `<TypeDefinitions>` (2.2.3): `type` is Real, Integer ..., `attributes` are that element's."""
    name: str
    type: str
    attributes: dict[str, str]
    items: list[dict[str, str]] = field(default_factory=list)


@dataclass
class Variable:
    """A `<ScalarVariable>` (2.2.7); `own` are the attributes of its Real, Integer, ... element.

    An array of FMI 3.0 has a `shape`, and `starts` for its elements. Each element is a variable as well, the `place`-th
    (from 0) of `array`.
    """
    index: int
    attributes: dict[str, str]
    type: str
    own: dict[str, str]
    declared: SimpleType | None = None
    shape: tuple[int, ...] | None = None
    starts: list[str] = field(default_factory=list)
    array: str = ""
    place: int = 0

    @property
    def name(self) -> str:
        """The name; empty where there is none."""
        return self.attributes.get("name", "")

    @property
    def description(self) -> str:
        """The description; empty where there is none."""
        return self.attributes.get("description", "")

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
    def smooth(self) -> bool:
        """Whether it is a real number that may change at any time."""
        return self.family == "Real" and self.variability == "continuous"

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
    def family(self) -> str:
        """Real, Integer, Boolean, String, Enumeration, Binary or Clock, whatever the version and the width."""
        return FAMILIES.get(self.type, self.type)

    def elements(self) -> "list[Variable]":
        """The elements of an array, x[1], x[2] or x[1,1], x[1,2] ..., the last index changing first; of another
        variable itself."""
        if self.shape is None:
            return [self]
        starts = self.starts * math.prod(self.shape) if len(self.starts) == 1 else self.starts
        found = []
        for place, indices in enumerate(product(*(range(1, n + 1) for n in self.shape))):
            name = f"{self.name}[{','.join(map(str, indices))}]"
            own = {**self.own, "start": starts[place]} if place < len(starts) else self.own
            found.append(replace(self, attributes={**self.attributes, "name": name}, own=own, shape=None, starts=[],
                                 array=self.name, place=place))
        return found

    @property
    def base(self) -> str:
        """The type by which the C functions know the variable: an Enumeration is read with fmi2GetInteger."""
        return "Integer" if self.type == "Enumeration" else self.type

    def resolved(self, attribute: str) -> str | None:
        """The variable's own attribute, or else the one of its declared type (2.2.7, `declaredType`)."""
        inherited = self.declared.attributes.get(attribute) if self.declared else None
        return self.own.get(attribute, inherited)

    @property
    def min(self) -> float | None:
        """The least value allowed, its own or its type's."""
        return number(self.resolved("min"))

    @property
    def max(self) -> float | None:
        """The greatest value allowed, its own or its type's."""
        return number(self.resolved("max"))

    @property
    def nominal(self) -> float | None:
        """The usual magnitude, its own or its type's."""
        return number(self.resolved("nominal"))

    @property
    def unit(self) -> str:
        """The unit's name, its own or its type's; empty without one."""
        return self.resolved("unit") or ""

    @property
    def display_unit(self) -> str:
        """The display unit's name, its own or its type's; empty without one."""
        return self.resolved("displayUnit") or ""

    @property
    def relative(self) -> bool:
        """Whether it is a difference, to which offsets of units do not apply (2.2.3, relativeQuantity)."""
        return is_true(self.resolved("relativeQuantity"))

    @property
    def items(self) -> dict[str, int]:
        """The items of an Enumeration: name -> value."""
        listed = self.declared.items if self.declared else []
        values = {item.get("name", ""): integer(item.get("value")) for item in listed}
        return {name: value for name, value in values.items() if value is not None}


@dataclass
class Unknown:
    """An `<Unknown>` of `<ModelStructure>` (2.2.8); `None` means that the attribute is absent."""
    index: int | None
    dependencies: list[int] | None
    kinds: list[str] | None


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


def is_true(text: str | None) -> bool:
    """Whether an attribute says true, as XML writes it."""
    return text is not None and text.strip() in ("true", "1")
