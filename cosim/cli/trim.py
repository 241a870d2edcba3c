"""`ahv trim`."""
from ..errors import RunError
from .options import Altitude, Flavour, Json, Velocity
from .show import report


def trim(V: Velocity = 7700.0, h: Altitude = 85000.0, flavour: Flavour = None, as_json: Json = False) -> None:
    """Solve level flight with the plant FMU. Exit status 1 if it needs more than the actuators can give."""
    from ..vehicle.trim import beyond_limits
    from ..vehicle.trim import trim as solve

    found = solve(V, h, flavour)
    report(found, as_json)
    if beyond := beyond_limits(found, flavour):
        raise RunError(beyond)
