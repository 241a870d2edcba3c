"""Units of variables, in SI base units as modelDescription.xml wants them.

A unit is "1", or symbols with whole exponents, multiplied with "." and divided with "/": slug.ft/s^2, mm, 1/s. UDUNITS
and pint read these; s2 is known as well, but not to pint. A model may name units of its own in the same way, in its
UNITS: name -> (how many, of which unit), such as {"furlong": (220, "yd")}.
"""
import re
from collections.abc import Mapping
from math import pi

DEGREES = 180 / pi

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")  # in the order of FMI 2.0 section 2.2.2

Worth = tuple[float, str]  # how many, of which unit

# Symbol -> its worth in symbols that stand above it.
METRIC: dict[str, Worth] = {  # these have prefixes: mN, kPa
    "g": (1e-3, "kg"), "Hz": (1, "1/s"), "N": (1, "kg.m/s^2"), "Pa": (1, "N/m^2"), "J": (1, "N.m"), "W": (1, "J/s"),
    "C": (1, "A.s"), "V": (1, "W/A"), "F": (1, "C/V"), "Ohm": (1, "V/A"), "S": (1, "A/V"), "Wb": (1, "V.s"),
    "T": (1, "Wb/m^2"), "H": (1, "Wb/A"), "L": (1e-3, "m^3"), "bar": (1e5, "Pa"), "eV": (1.602176634e-19, "J"),
}
OTHERS: dict[str, Worth] = {
    "min": (60, "s"), "h": (3600, "s"), "d": (86400, "s"), "t": (1000, "kg"),
    "deg": (pi / 180, "rad"), "rev": (2 * pi, "rad"), "rpm": (pi / 30, "rad/s"),
    "ft": (0.3048, "m"), "inch": (0.0254, "m"), "yd": (0.9144, "m"), "mi": (1609.344, "m"), "nmi": (1852, "m"),
    "knot": (1, "nmi/h"), "mph": (1, "mi/h"),
    "slug": (14.593902937206365, "kg"), "lb": (0.45359237, "kg"), "lbf": (1, "slug.ft/s^2"), "psi": (1, "lbf/inch^2"),
    "atm": (101325, "Pa"), "hp": (550, "ft.lbf/s"),
}
FROM_ELSEWHERE = ("degC", "degF", "Celsius", "Fahrenheit")  # a unit here is a factor
SYMBOLS = [*BASE_UNITS, *METRIC, *OTHERS]
PREFIXES = {"f": 1e-15, "p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "h": 1e2, "k": 1e3, "M": 1e6,
            "G": 1e9, "T": 1e12}
PREFIXED = {prefix + symbol: (factor, symbol) for symbol in [*BASE_UNITS[1:], *METRIC]
            for prefix, factor in PREFIXES.items()}
WORTH = PREFIXED | METRIC | OTHERS  # a symbol of its own, such as min or h, is no prefix
RULE = (f"a unit is 1 or made of {', '.join(SYMBOLS)}, of SI prefixes and of what the model's UNITS name, such as "
        "slug.ft/s^2 or 1/s")


def si_base(unit: str, own: Mapping[str, Worth] | None = None) -> tuple[float, dict[str, int]]:
    """(SI factor, {base unit: exponent}) of a unit, the exponents in the order of BASE_UNITS; `own` is a model's UNITS.

    Raises ValueError for what is no unit.
    """
    factor = 1.0
    total = dict.fromkeys(BASE_UNITS, 0)
    for operator, piece in re.findall(r"(^|[./])([^./]*)", unit):
        size, exponents = (1.0, {}) if piece == "1" else power(piece, own or {})
        factor = factor / size if operator == "/" else factor * size
        for base, exponent in exponents.items():
            total[base] += -exponent if operator == "/" else exponent
    return factor, {base: exponent for base, exponent in total.items() if exponent}


def power(piece: str, own: Mapping[str, Worth]) -> tuple[float, dict[str, int]]:
    """As `si_base`, of a symbol with its exponent, such as s^2. Raises ValueError for another."""
    found = re.fullmatch(r"([A-Za-z]+)(?:\^?(-?\d+))?", piece, re.ASCII)
    n = int(found[2] or 1) if found else 1
    if found and found[1] in BASE_UNITS:
        return 1.0, {found[1]: n}
    if found and found[1] in FROM_ELSEWHERE:
        raise ValueError(f"{piece!r} is not known, for its zero is not that of K; give temperatures in K")
    worth = (own.get(found[1]) or WORTH.get(found[1])) if found else None
    if not found or worth is None:
        raise ValueError(f"{piece!r} is not known; {RULE}")
    size, exponents = si_base(worth[1])  # a model's unit is made of the units here
    return float((worth[0] * size)**n), {base: exponent * n for base, exponent in exponents.items()}


def per_second(unit: str) -> str:
    """The unit of the rate of a variable in `unit`: ft/s for ft, ft/s^2 for ft/s."""
    if unit == "s" or unit.endswith(".s"):
        return unit[:-2] or "1"
    before, found = re.subn(r"/s(?:\^?(\d+))?$", lambda last: f"/s^{int(last[1] or 1) + 1}", unit)
    return before if found else f"{unit}/s"
