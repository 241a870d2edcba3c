"""Systems that stay loaded from flight to flight."""
from collections.abc import Hashable
from contextlib import ExitStack
from typing import Any

from ..errors import RunError
from .loaded import Master, open_files
from .system import System


class Kept:
    """A system that is loaded when it is first asked for, and reset for each further flight; `options` are those of
    Master, where `record` may also be a function of the open FMU files.

    An FMU that cannot be reset, or that answered Fatal, is loaded anew.
    """

    def __init__(self, **options: Any):
        self.options = options
        self.master: Master | None = None
        self.stack = ExitStack()

    def ready(self, system: System) -> Master:
        """`system`, which differs from the one before in its values only, to be initialised.

        Raises UsageError for values or options that do not fit, RunError if an FMU cannot be started.
        """
        if self.master is not None:
            try:
                self.master.reset(system)
                return self.master
            except RunError:
                self.close()
        with ExitStack() as stack:
            files = stack.enter_context(open_files(system))
            options = {name: one(files) if callable(one) else one for name, one in self.options.items()}
            master = Master(system, files, **options)
            stack.callback(master.close)
            self.master, self.stack = master, stack.pop_all()
        return master

    def close(self) -> None:
        """End and unload its FMUs. It may be asked for again."""
        self.master = None
        self.stack.close()


class KeptSystems:
    """Several systems that stay loaded in one process, by a key."""

    def __init__(self) -> None:
        self.kept: dict[Hashable, Kept] = {}

    @property
    def masters(self) -> dict[Hashable, Master]:
        """Those that are loaded."""
        return {key: one.master for key, one in self.kept.items() if one.master}

    def ready(self, key: Hashable, system: System, **options: Any) -> Master:
        """The system of a key, to be initialised; `options` count when it is first asked for. Raises what `Kept.ready`
        raises."""
        kept = self.kept.setdefault(key, Kept(**options))
        if kept.master is None and any(one.only_one for master in self.masters.values() for one in master.instances):
            self.close()  # an FMU that allows one instance in a process may be in several systems
        return kept.ready(system)

    def drop_dead(self) -> None:
        """Unload systems of which an FMU answered Fatal: no function of that FMU may be called then."""
        for key, master in self.masters.items():
            if not all(instance.alive for instance in master.instances):
                self.drop(key)

    def drop(self, key: Hashable) -> None:
        """Unload the system of a key."""
        if key in self.kept:
            self.kept[key].close()

    def close(self) -> None:
        """Unload all systems."""
        for key in self.kept:
            self.drop(key)
