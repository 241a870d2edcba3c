"""Level flight, as the plant's FMU solves it."""
from collections.abc import Mapping
from math import degrees

from ..errors import RunError
from .closed_loop import LIMITS, flavour_of, fmu_path
from .registry import LAWS, PLANTS

ARRIVED = 1e-6  # largest state derivative of a flight that is level, mixed units per second


def trim(V: float = 7700.0, h: float = 85000.0, flavour: str | None = None) -> dict[str, float]:
    """The equilibrium at `V` (ft/s) and `h` (ft): angles in degrees, elastic coordinates, fuel ratio, residual.

    It may need more than the actuators can give, see `beyond_limits`. Raises UsageError for a start that the plant does
    not allow, RunError if there is no equilibrium.
    """
    from ..master.fmu import FmuFile
    from ..master.instance import Instance

    with FmuFile.open(fmu_path(flavour_of(flavour), PLANTS["ideal"].fmu)) as file:
        values = {name: file.checked(name, value, "plant") for name, value in (("V_start", V), ("h_start", h))}
        instance = Instance(file, "plant")
        try:
            instance.set(values)
            instance.enter(0.0, 1.0)
            names = ("theta_trim", "eta1", "eta2", "fuel_ratio_trim", "elevator_trim", "trim_residual")
            theta, eta1, eta2, fuel_ratio, elevator, residual = instance.get(names)
        finally:
            instance.close()
    if not residual <= ARRIVED:
        raise RunError(f"No level flight was found at V = {V:g} ft/s, h = {h:g} ft.")
    return {"V_fps": V, "h_ft": h, "theta_deg": degrees(theta), "eta1": eta1, "eta2": eta2,
            "fuel_ratio": fuel_ratio, "elevator_deg": degrees(elevator), "residual": residual}


def beyond_limits(found: dict[str, float], flavour: str | None = None) -> str:
    """A sentence about the actuators that `found`, the answer of `trim`, needs beyond their limits; empty if none.

    The limits are those to which our laws keep the actuators by default.
    """
    from ..master.declared import number
    from ..master.fmu import FmuFile

    with FmuFile.open(fmu_path(flavour_of(flavour), next(iter(LAWS.values())).fmu)) as file:
        return beyond(found, {name: number(file.variable(name).start) or 0.0 for pair in LIMITS for name in pair})


def beyond(found: Mapping[str, float], limits: Mapping[str, float]) -> str:
    """The same with `limits`, by their names (rad)."""
    actuators = (("a fuel ratio", found["fuel_ratio"], limits["fuel_ratio_min"], limits["fuel_ratio_max"], ""),
                 ("an elevator", found["elevator_deg"], degrees(limits["elevator_min"]),
                  degrees(limits["elevator_max"]), " deg"))
    needs = [f"{name} of {value:.4g}{unit} ({low:g} to {high:g}{unit} is allowed)"
             for name, value, low, high, unit in actuators if not low <= value <= high]
    where = f"V = {found['V_fps']:g} ft/s, h = {found['h_ft']:g} ft"
    return f"Level flight at {where} is beyond the vehicle's limits: it needs {' and '.join(needs)}." if needs else ""
