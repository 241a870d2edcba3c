"""A system of FMUs as a function from values to figures of its flight, for studies and optimisers of others."""
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from os import PathLike
from typing import Any, Self

import numpy as np

from ..errors import RunError, UsageError
from ..master.algorithms import method
from ..master.connections import recorded_names
from ..master.flight import Flight
from ..master.fly import fly_loaded, tick_count
from ..master.kept import Kept
from ..master.loaded import open_files
from ..master.recording import Whole
from ..master.system import System
from .judge import expression, of_flight
from .opened import needed, opened, pythons_words
from .ports import variable


class Function:
    """`function(values)` flies a system with `values`, shape (inputs,), and gives figures of its flight, (figures,);
    of values of shape (flights, inputs) it gives (flights, figures).

    system      a cosim.System, a file (.fmu, .ssp, .ssd, .yaml), or what `ahv run` flies, such as "case1"
    inputs      what the values are set to: parameters, start values and inputs, `component.variable`
    figures     name -> an expression on signals, such as "max(plant.h) - min(plant.h)", or a function of the Flight,
                such as `lambda flight: flight["plant.h"].max()`
    record      patterns of the signals that functions need, `*` for any; else all numeric outputs
    step, stop  s; else what the system's file suggests
    algorithm   as that of `cosim.fly`; else the file's, or gauss-seidel
    lost        what all figures of a flight are that an FMU does not let come to its end; if it is None, that raises
                RunError. A flight that an FMU ends as FMI lets it has figures: those of what was flown

    Values are in the units that the FMUs declare. The system stays loaded from flight to flight, until `close` or the
    end of a `with`. Raises UsageError for what does not fit, RunError if an FMU cannot be started.
    """

    @pythons_words()
    def __init__(self, system: System | str | PathLike[str], inputs: Sequence[str],
                 figures: Mapping[str, str | Callable[[Flight], float]], *, record: Sequence[str] | None = None,
                 step: float | None = None, stop: float | None = None, algorithm: str | None = None,
                 lost: float | None = None):
        if isinstance(inputs, str):
            raise UsageError(f"inputs = {inputs!r} is not allowed: it must be a list of names.")
        self.stack = ExitStack()
        flown, suggested = opened(system, self.stack)
        self.inputs, self.lost, self.method = [*inputs], lost, method(algorithm or suggested)
        self.start, self.step = flown.start, needed("step", step, flown.step)
        self.ticks = tick_count(self.step, needed("stop", stop, flown.stop), self.start)
        named = [name for word, figure in figures.items() if (found := expression(word, figure))
                 for name in found.names]
        with open_files(flown) as files:
            for name in named:
                variable("figures", name, files)
            outputs = recorded_names(flown, files, None if record is None else list(record))
        functions = any(callable(figure) for figure in figures.values())
        self.system, self.kept = flown, Kept(record=[*named, *(outputs if functions else ())])
        columns = self.kept.ready(flown).columns
        self.figures = {word: of_flight(word, figure, [c.name for c in columns]) for word, figure in figures.items()}
        self.recorder = Whole(columns, self.ticks + 2)

    @pythons_words()
    def __call__(self, values: Any) -> np.ndarray:
        """Raises UsageError for values of another shape or that do not fit, RunError for a flight that ends early, if
        `lost` is None."""
        given = np.asarray(values, float)
        if given.ndim not in (1, 2) or given.shape[-1] != len(self.inputs):
            raise UsageError(f"Values of shape {given.shape} are not allowed: there must be {len(self.inputs)} in a row"
                             f", for {', '.join(self.inputs)}.")
        if given.ndim == 2:
            return np.array([self(row) for row in given]).reshape(len(given), len(self.figures))
        flight = self.fly(given)
        if flight is None or not flight.finished:
            return np.full(len(self.figures), self.lost)
        return np.array([self.figure(word, flight) for word in self.figures])

    def figure(self, word: str, flight: Flight) -> float:
        """One figure of a flight; `lost` where it has no value, or RunError if that is None."""
        try:
            return float(self.figures[word](flight))
        except ValueError as error:
            if self.lost is None:
                raise RunError(f"{word}: {error}.") from None
            return self.lost

    def fly(self, values: np.ndarray) -> Flight | None:
        """The flight with `values`, shape (inputs,); its rows are valid until the next one. One that did not start is
        None. Raises what a call does."""
        try:
            master = self.kept.ready(self.system.with_values(dict(zip(self.inputs, values.tolist()))))
            flight = fly_loaded(master, self.method, self.step, self.ticks, start=self.start,
                                recorder=self.recorder.restart())
        except RunError:
            if self.lost is None:
                raise
            return None
        flight.check_interrupted()
        if not flight.finished and self.lost is None:
            raise RunError(flight.message)
        return flight

    def close(self) -> None:
        """End and unload the FMUs."""
        self.kept.close()
        self.stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
