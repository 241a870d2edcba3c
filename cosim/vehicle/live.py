"""What the live page has of our flights: gauges, curves, and buttons that step the coefficient groups."""
from collections.abc import Callable

from ..errors import UsageError
from ..live.board import Board, Chart, Gauge, Lever
from ..live.show import Show
from ..master.guard import POSSIBLE
from .closed_loop import LIMITS, ClosedLoop
from .scenario_model import SCALES

STEP, MOST = 0.1, 0.5  # of the nominal coefficients; the scenarios' own swing of 0.4 leaves them positive
FUEL_LIMITS, ELEVATOR_LIMITS = ((f"controller.{low}", f"controller.{high}") for low, high in LIMITS)
NAMES = {"scale_forces": "Generalised forces", "scale_moment": "Pitching moment"}
GAUGES = (
    Gauge("Velocity V", "plant.V", 7500.0, 9000.0, "controller.V_reference"),
    Gauge("Altitude h", "plant.h", 84_000.0, 87_000.0, "controller.h_reference"),
    Gauge("Path angle γ", "plant.gamma", -1.0, 1.0, "controller.gamma_command"),
    Gauge("Angle of attack α", "plant.alpha", -2.0, 6.0),
    Gauge("Elevator", "controller.elevator", -30.0, 30.0, limits=ELEVATOR_LIMITS),
    Gauge("Fuel ratio", "controller.fuel_ratio", 0.0, 1.5, limits=FUEL_LIMITS),
)
CHARTS = (
    Chart("Velocity", ("plant.V", "controller.V_reference")),
    Chart("Altitude", ("plant.h", "controller.h_reference")),
    Chart("Angles", ("plant.gamma", "plant.alpha")),
    Chart("Elevator", ("controller.elevator",), ELEVATOR_LIMITS),
    Chart("Fuel ratio", ("controller.fuel_ratio",), FUEL_LIMITS),
    Chart("Scales of the coefficients that the plant is given", tuple(f"plant.{name}" for name in SCALES)),
)


def shown_live(loop: ClosedLoop, title: str, stop: float, factor: float, announce: Callable[[str], None]) -> Show:
    """The live page of a flight of `loop` to `stop` (s), paced by `factor`; `announce` is told its address.

    Raises UsageError where a flight cannot fly in a process of its own.
    """
    if not POSSIBLE:
        raise UsageError("--live needs a system on which a process can fork, such as Linux or macOS.")
    connected = {link.target for link in loop.system.connections}
    levers = [Lever(NAMES.get(name, name.removeprefix("scale_").capitalize()), f"plant.{name}", STEP, MOST)
              for name in SCALES if f"plant.{name}" in connected]
    notes = [] if levers else ["The plant has no input for the scale of a coefficient group: nothing can be stepped."]
    return Show(Board(title, stop, factor, GAUGES, levers, CHARTS, [*loop.notes, *notes]), announce)
