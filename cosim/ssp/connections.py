"""Connections through nested systems, with units, as the master's connections between FMUs."""
from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite

from ..errors import UsageError
from ..master.quantities import Unit, between, conversion
from .structure import Link, Point, Structure, called

UnitOf = Callable[[Point], Unit | None]


@dataclass(frozen=True)
class Traced:
    """What arrives somewhere: factor * (what leaves `origin`) + offset, in `unit` where that is known."""
    origin: Point
    unit: Unit | None
    factor: float = 1.0
    offset: float = 0.0

    def through(self, link: Link, end: Unit | None, relative: bool) -> "Traced":
        """Along a connection that ends in the unit `end`: first the conversion, then the linear transformation.

        Of a difference, if `relative`, only the unit's factor counts. Raises UsageError if there is no conversion.
        """
        change = (1.0, 0.0)
        if link.converts and self.unit and end:
            found = conversion(self.unit, end, relative)
            if found is None:
                raise UsageError(f"The connection from {called(link.start)} to {called(link.end)} cannot convert "
                                 f"{' to '.join(between(self.unit, end))}.")
            change = found
        factor, offset = link.factor * change[0], link.factor * change[1] + link.offset
        if not (isfinite(factor) and isfinite(offset)):
            raise UsageError(f"The connection from {called(link.start)} to {called(link.end)} has the factor "
                             f"{link.factor:g} and the offset {link.offset:g}; they have to be finite.")
        unit = end or (self.unit if link.converts else None)
        return Traced(self.origin, unit, factor * self.factor, factor * self.offset + offset)


@dataclass
class Tracer:
    """Follows connections back to where a value comes from: an FMU, or a system's connector that nothing feeds."""
    structure: Structure
    unit_of: UnitOf
    relative: Callable[[Point], bool]    # whether a point is a variable of an FMU that is a difference
    incoming: dict[Point, Link] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for link in self.structure.links:
            if link.end in self.incoming:
                raise UsageError(f"{called(link.end)} has more than one connection.")
            self.incoming[link.end] = link

    def at(self, point: Point) -> Traced:
        """What arrives at `point`. Raises UsageError for a circle, or for units that cannot be converted."""
        path: list[Link] = []
        while point in self.incoming:
            link = self.incoming[point]
            if link in path:
                raise UsageError(f"The connections lead in a circle through {called(point)}.")
            path.append(link)
            point = link.start
        traced = Traced(point, self.unit_of(point))
        relative = self.relative(point) or bool(path and self.relative(path[0].end))
        for link in reversed(path):
            traced = traced.through(link, self.unit_of(link.end), relative)
        return traced
