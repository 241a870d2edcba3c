"""The signals of a system at one time, as rewards and conditions see them."""
from collections.abc import Mapping

from ..errors import did_you_mean
from ..master.flight import NoSuchSignal


class Moment:
    """`now["component.variable"]` is a signal in the unit that its FMU declares, `now.time` the time, s; `now.before`
    is the Moment one action earlier, after a reset None."""
    __slots__ = ("before", "places", "row", "time")

    def __init__(self, places: Mapping[str, int], row: list[float], time: float, before: "Moment | None" = None):
        self.places, self.row, self.time = places, row, time
        self.before = before

    def __contains__(self, name: object) -> bool:
        return name in self.places

    def __getitem__(self, name: str) -> float:
        """Raises UsageError, which is a KeyError too, for a signal that is not there."""
        try:
            return self.row[self.places[name]]
        except KeyError:
            raise NoSuchSignal(f"There is no signal {name}{did_you_mean(name, self.places)} Only actions, observations "
                               f"and what signals=[...] names are kept.") from None
