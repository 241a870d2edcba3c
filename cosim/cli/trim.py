"""`ahv trim`."""
from .options import Altitude, Flavour, Json, Velocity
from .show import report


def trim(V: Velocity = 7700.0, h: Altitude = 85000.0, flavour: Flavour = None, as_json: Json = False) -> None:
    """Solve level flight with the plant FMU."""
    from ..vehicle.trim import trim as solve

    report(solve(V, h, flavour), as_json)
