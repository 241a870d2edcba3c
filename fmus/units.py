"""The units of the vehicle's variables in SI base units, as modelDescription.xml wants them."""
from math import pi

FT, SLUG = 0.3048, 14.593902937206365
LBF = SLUG * FT

# unit -> (SI factor, {base unit: exponent}), or None where exponents are not whole numbers.
UNITS: dict[str, tuple[float, dict[str, int]] | None] = {
    "1": (1.0, {}),
    "s": (1.0, {"s": 1}),
    "1/s": (1.0, {"s": -1}),
    "1/s2": (1.0, {"s": -2}),
    "1/s3": (1.0, {"s": -3}),
    "1/ft2": (FT**-2, {"m": -2}),
    "s2/rad2": (1.0, {"s": 2, "rad": -2}),
    "ft": (FT, {"m": 1}),
    "ft/s": (FT, {"m": 1, "s": -1}),
    "ft/s2": (FT, {"m": 1, "s": -2}),
    "rad": (1.0, {"rad": 1}),
    "rad/s": (1.0, {"rad": 1, "s": -1}),
    "rad/s2": (1.0, {"rad": 1, "s": -2}),
    "rad/s3": (1.0, {"rad": 1, "s": -3}),
    "slug/ft": (SLUG / FT, {"kg": 1, "m": -1}),
    "slug.ft": (SLUG * FT, {"kg": 1, "m": 1}),
    "slug/ft3": (SLUG / FT**3, {"kg": 1, "m": -3}),
    "lbf": (LBF, {"kg": 1, "m": 1, "s": -2}),
    "lbf/ft": (LBF / FT, {"kg": 1, "s": -2}),
    "lbf/ft2": (LBF / FT**2, {"kg": 1, "m": -1, "s": -2}),
    "sqrt(slug.ft)": None,
    "sqrt(slug.ft)/s": None,
    "sqrt(slug.ft)/s2": None,
}

DEGREES = 180 / pi
