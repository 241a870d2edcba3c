"""Level flight, as the plant's FMU solves it."""
from math import degrees

from .closed_loop import flavour_of, fmu_path
from .registry import PLANTS


def trim(V: float = 7700.0, h: float = 85000.0, flavour: str | None = None) -> dict[str, float]:
    """The equilibrium at `V` (ft/s) and `h` (ft): angles in degrees, elastic coordinates, fuel ratio, residual.

    Raises UsageError for a start that the plant does not allow.
    """
    from ..master.fmu import FmuFile
    from ..master.instance import Instance

    file = FmuFile.open(fmu_path(flavour_of(flavour), PLANTS["ideal"].fmu))
    instance = None
    try:
        values = {name: file.checked(name, value, "plant") for name, value in (("V_start", V), ("h_start", h))}
        instance = Instance(file, "plant")
        instance.set(values)
        instance.setup(0.0, 1.0)
        instance.simple("fmi2EnterInitializationMode")
        names = ("theta_trim", "eta1", "eta2", "fuel_ratio_trim", "elevator_trim", "trim_residual")
        theta, eta1, eta2, fuel_ratio, elevator, residual = instance.get(names)
    finally:
        if instance:
            instance.close()
        file.close()
    return {"V_fps": V, "h_ft": h, "theta_deg": degrees(theta), "eta1": eta1, "eta2": eta2,
            "fuel_ratio": fuel_ratio, "elevator_deg": degrees(elevator), "residual": residual}
