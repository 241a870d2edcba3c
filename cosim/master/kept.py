"""A system that stays loaded from flight to flight."""
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

from ..errors import RunError
from .loaded import Master, open_files
from .system import System, Value


class Kept:
    """Loads `system` when it is first asked for, and resets it for each further flight; `options` are those of Master.

    An FMU that cannot be reset, or that answered Fatal, is loaded anew.
    """

    def __init__(self, system: System, **options: Any):
        self.system, self.options = system, options
        self.master: Master | None = None
        self.stack = ExitStack()

    def ready(self, values: Mapping[str, Value]) -> Master:
        """The system with `values` (component.variable -> value) over its own, to be initialised.

        Raises UsageError for values or options that do not fit, RunError if an FMU cannot be started.
        """
        system = self.system.with_values(values)
        if self.master is not None:
            try:
                self.master.reset(system)
                return self.master
            except RunError:
                self.close()
        with ExitStack() as stack:
            files = stack.enter_context(open_files(system))
            master = Master(system, files, **self.options)
            stack.callback(master.close)
            self.master, self.stack = master, stack.pop_all()
        return master

    def close(self) -> None:
        """End and unload its FMUs. It may be asked for again."""
        self.master = None
        self.stack.close()
