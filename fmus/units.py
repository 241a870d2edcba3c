"""Units of variables, in SI base units as modelDescription.xml wants them.

A unit is "1", or symbols with whole exponents, multiplied with "." and divided with "/": slug.ft/s^2, 1/s. UDUNITS and
pint read these; s2 is known as well, but not to pint.
"""
import re
from math import pi

FT, SLUG = 0.3048, 14.593902937206365
DEGREES = 180 / pi

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")  # in the order of FMI 2.0 section 2.2.2

# symbol -> (SI factor, {base unit: exponent})
SYMBOLS: dict[str, tuple[float, dict[str, int]]] = {
    **{base: (1.0, {base: 1}) for base in BASE_UNITS},
    "ft": (FT, {"m": 1}),
    "slug": (SLUG, {"kg": 1}),
    "lbf": (SLUG * FT, {"kg": 1, "m": 1, "s": -2}),
    "deg": (pi / 180, {"rad": 1}),
    "Hz": (1.0, {"s": -1}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "V": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -1}),
}
RULE = f"a unit is 1 or made of {', '.join(SYMBOLS)}, such as slug.ft/s^2 or 1/s"


def si_base(unit: str) -> tuple[float, dict[str, int]]:
    """(SI factor, {base unit: exponent}) of a unit, the exponents in the order of BASE_UNITS.

    Raises ValueError for what is no unit.
    """
    factor = 1.0
    total = dict.fromkeys(BASE_UNITS, 0)
    for operator, piece in re.findall(r"(^|[./])([^./]*)", unit):
        size, exponents = (1.0, {}) if piece == "1" else power(piece)
        factor = factor / size if operator == "/" else factor * size
        for base, exponent in exponents.items():
            total[base] += -exponent if operator == "/" else exponent
    return factor, {base: exponent for base, exponent in total.items() if exponent}


def per_second(unit: str) -> str:
    """The unit of the rate of a variable in `unit`: ft/s for ft, ft/s^2 for ft/s."""
    if unit == "s" or unit.endswith(".s"):
        return unit[:-2] or "1"
    before, found = re.subn(r"/s(?:\^?(\d+))?$", lambda last: f"/s^{int(last[1] or 1) + 1}", unit)
    return before if found else f"{unit}/s"


def power(piece: str) -> tuple[float, dict[str, int]]:
    """As `si_base`, of a symbol with its exponent, such as s^2. Raises ValueError for another."""
    found = re.fullmatch(r"([A-Za-z]+)(?:\^?(-?\d+))?", piece, re.ASCII)
    if not found or found[1] not in SYMBOLS:
        raise ValueError(f"{piece!r} is not known; {RULE}")
    size, exponents = SYMBOLS[found[1]]
    n = int(found[2] or 1)
    return size**n, {base: exponent * n for base, exponent in exponents.items()}
