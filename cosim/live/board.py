"""What a live page shows and offers, as data: a room says it of its flights."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..master.flight import Flight
from ..master.wiring import Signal


@dataclass(frozen=True)
class Gauge:
    """A signal on a scale from `low` to `high` (display units; it widens if the signal leaves it), with the signal that
    it is to follow, and parameters (component.variable) that limit it."""
    title: str
    signal: str
    low: float
    high: float
    commanded: str = ""
    limits: tuple[str, str] | None = None


@dataclass(frozen=True)
class Lever:
    """An input that buttons step by `step`, up to `most` either way, in its unit."""
    title: str
    input: str
    step: float
    most: float


@dataclass(frozen=True)
class Chart:
    """Signals over time, by name, in one panel."""
    title: str
    signals: tuple[str, ...]
    limits: tuple[str, str] | None = None


@dataclass(frozen=True)
class Board:
    """All of a page: signals that a flight does not record are left out."""
    title: str
    stop: float
    factor: float
    gauges: Sequence[Gauge]
    levers: Sequence[Lever]
    charts: Sequence[Chart]
    notes: Sequence[str] = ()

    def signals(self, columns: Sequence[Signal]) -> list[Signal]:
        """The recorded signals that the page shows."""
        shown = {name for gauge in self.gauges for name in (gauge.signal, gauge.commanded)}
        shown |= {name for chart in self.charts for name in chart.signals} | {lever.input for lever in self.levers}
        return [column for column in columns if column.name in shown]

    def about(self, flight: Flight) -> dict[str, Any]:
        """What the page's script is told first, as JSON goes; values are in the units that FMUs declare, and each
        signal has the factor and offset of the unit that is shown."""
        known = self.signals(flight.columns)
        units = {c.name: {"unit": c.display_unit or c.unit, "factor": c.display_factor if c.display_unit else 1.0,
                          "offset": c.display_offset if c.display_unit else 0.0, "description": c.description}
                 for c in known}
        return {"title": self.title, "stop": self.stop, "factor": self.factor, "notes": list(self.notes),
                "signals": units,
                "gauges": [{"title": g.title, "signal": g.signal, "low": g.low, "high": g.high,
                            "commanded": g.commanded if g.commanded in units else "",
                            "limits": limits_of(g.limits, flight.parameters)}
                           for g in self.gauges if g.signal in units],
                "levers": [{"title": x.title, "input": x.input, "step": x.step, "most": x.most} for x in self.levers],
                "charts": [{"title": c.title, "signals": names, "limits": limits_of(c.limits, flight.parameters)}
                           for c in self.charts if (names := [n for n in c.signals if n in units])]}


def limits_of(names: tuple[str, str] | None, parameters: Mapping[str, Mapping[str, Any]]) -> list[float] | None:
    """The values of two parameters (component.variable); None if the flight does not have both."""
    found = [parameters.get(component, {}).get(variable) for component, _, variable
             in (name.partition(".") for name in names or ())]
    numbers = [float(x) for x in found if isinstance(x, int | float)]
    return numbers if len(numbers) == 2 else None
