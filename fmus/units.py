"""Units of variables, in SI base units as modelDescription.xml wants them.

A unit is "1", or symbols with whole exponents, multiplied with "." and divided with "/": slug.ft/s2, 1/s. A square root
stands as sqrt(slug.ft).
"""
import re
from math import pi

FT, SLUG = 0.3048, 14.593902937206365
DEGREES = 180 / pi

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")  # in the order of FMI 2.0 section 2.2.2

# symbol -> (SI factor, {base unit: exponent})
SYMBOLS: dict[str, tuple[float, dict[str, float]]] = {
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
RULE = f"a unit is 1 or made of {', '.join(SYMBOLS)}, such as slug.ft/s2, 1/s or sqrt(slug.ft)"


def si_base(unit: str) -> tuple[float, dict[str, int]] | None:
    """(SI factor, {base unit: exponent}) of a unit, or None where exponents are not whole numbers.

    Raises ValueError for what is no unit.
    """
    factor, exponents = product(unit)
    if any(exponent % 1 for exponent in exponents.values()):
        return None
    return factor, {base: int(exponents[base]) for base in BASE_UNITS if exponents.get(base)}


def product(unit: str) -> tuple[float, dict[str, float]]:
    """As `si_base`, with any exponents."""
    factor: float = 1.0
    total: dict[str, float] = {}
    # Each piece of slug.ft/s2 with what stands before it; what is in brackets is one piece.
    pieces = re.findall(r"(^|[./])(sqrt\([^()]*\)|[^./()]+)", unit)
    if "".join(operator + piece for operator, piece in pieces) != unit or not pieces or pieces[0][0]:
        raise ValueError(f"{unit!r} is not known; {RULE}")
    for operator, piece in pieces:
        size, exponents = (1.0, {}) if piece == "1" else power(piece)
        factor = factor / size if operator == "/" else factor * size
        for base, exponent in exponents.items():
            total[base] = total.get(base, 0) + (-exponent if operator == "/" else exponent)
    return factor, total


def power(piece: str) -> tuple[float, dict[str, float]]:
    """As `product`, of a symbol with its exponent, such as s2, or of a square root. Raises ValueError for another."""
    if piece.startswith("sqrt("):
        size, exponents = product(piece[5:-1])
        return size**0.5, {base: exponent / 2 for base, exponent in exponents.items()}
    found = re.fullmatch(r"([A-Za-z]+)(-?\d+)?", piece, re.ASCII)
    if not found or found[1] not in SYMBOLS:
        raise ValueError(f"{piece!r} is not known; {RULE}")
    size, exponents = SYMBOLS[found[1]]
    n = int(found[2] or 1)
    return size**n, {base: exponent * n for base, exponent in exponents.items()}
