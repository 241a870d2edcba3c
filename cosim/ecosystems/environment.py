"""A system of FMUs as an environment of Gymnasium, for agents that learn to act on it."""
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from math import isfinite
from operator import ge, le
from os import PathLike
from typing import Any

import numpy as np

from ..errors import RunError, UsageError
from ..master.algorithms import method
from ..master.flight import Flight
from ..master.loaded import Ended, open_files
from ..master.stepped import Stepped
from ..master.system import System
from .judge import of_moment
from .moment import Moment
from .opened import needed, opened, pythons_words
from .ports import Draw, Ports, actions_of, begins, bounds, drawn, observations_of

try:
    import gymnasium
    from gymnasium import spaces
except ImportError:
    raise UsageError("cosim.Environment needs gymnasium, which is not installed: pip install gymnasium.") from None


class Environment(gymnasium.Env[np.ndarray, np.ndarray]):
    """A system of FMUs that an agent acts on through inputs which nothing feeds, for `gymnasium`.

    system        a cosim.System, a file (.fmu, .ssp, .ssd, .yaml), or what `ahv run` flies, such as "case1"
    actions       the inputs, `component.variable`: a list, or a dict of name -> (low, high) or None. Limits are in the
                  input's unit; else those that the FMU declares; where it declares none, the start value minus or plus
                  one nominal value
    observations  the signals that the agent sees: as actions, any variable that is a number. Where the FMU declares no
                  limit, it is 1000 nominal values from 0
    reward        an expression on the signals after a step, such as "-abs(plant.h - 85000)", or a function of that
                  Moment, such as `lambda now: now["plant.h"] - now.before["plant.h"]`; else 0.0
    terminated    the same for a condition that ends the episode, such as "plant.h < 80000"
    signals       patterns of more signals for functions and for `flight`, `*` for any
    values        `component.variable` -> what is set at each reset: a value, (low, high) for a uniform draw, or a
                  function of a numpy random generator
    without       components that are left out: nothing feeds the inputs that they fed
    step, stop    communication step and end of an episode, s; else what the system's file suggests
    hold          communication steps for which an action is held
    algorithm     as that of `cosim.fly`, with steps that are equally long; else the file's, or gauss-seidel
    scaled        actions are -1 to 1, which stand for the limits; else they are in the inputs' units
    penalty       what is taken from the reward of the step in which the flight is lost, see below

    An action has shape (actions,). Where all inputs are whole numbers or truth values its space is MultiDiscrete, of
    those numbers; in a Box they are rounded. What is beyond the limits is taken as the limit. An observation has shape
    (observations,), float64, in the units that the FMUs declare.

    An episode is terminated when `terminated` says so, when an FMU ends the simulation, and when the flight is lost: an
    FMU refuses a step, or an observation leaves its limits or is no number. `info["message"]` then says which, in one
    sentence. The observation of a flight that is lost is the last one within the limits, and the reward is of the
    signals at that time. An episode is truncated at
    `stop`. `info["time"]` is the time, s; after a reset, `info["values"]` are the values that were drawn.

    Raises UsageError for what does not fit.
    """
    @pythons_words()
    def __init__(self, system: System | str | PathLike[str], actions: Ports, observations: Ports,
                 reward: str | Callable[[Moment], float] | None = None,
                 terminated: str | Callable[[Moment], bool] | None = None, *, signals: Sequence[str] = (),
                 values: Mapping[str, Draw] | None = None, without: Sequence[str] = (), step: float | None = None,
                 stop: float | None = None, hold: int = 1, algorithm: str | None = None, scaled: bool = True,
                 penalty: float = 0.0, render_mode: None = None):
        self.metadata = {"render_modes": []}
        self.stack = ExitStack()
        given, suggested = opened(system, self.stack)
        flown = given.without(*without)
        with open_files(flown) as files:
            start = begins(flown, files)
            self.actions = actions_of(actions, files, start)
            self.observations = observations_of(observations, files)
            self.reward, valued = of_moment("reward", reward, False, files)
            self.terminated, compared = of_moment("terminated", terminated, True, files)
        kept = [*(port.name for port in (*self.observations, *self.actions)), *valued, *compared, *signals]
        self.flown = Stepped(flown, {port.name: start[port.name] for port in self.actions}, kept,
                             needed("step", step, given.step), needed("stop", stop, given.stop),
                             method(algorithm or suggested), hold)
        self.penalty, self.draws = penalty, dict(values or {})
        low, high = bounds(self.observations)
        self.lows, self.highs = low.tolist(), high.tolist()
        self.least, self.most = bounds(self.actions)
        self.whole = np.array([port.whole for port in self.actions])
        self.rounds = bool(self.whole.any())
        self.action_space: spaces.Space[Any]
        self.middle, self.reach = np.zeros(len(self.actions)), np.ones(len(self.actions))
        if self.whole.all():
            self.action_space = spaces.MultiDiscrete((self.most - self.least + 1).astype(int),
                                                     start=self.least.astype(int))
        elif scaled:
            self.action_space = spaces.Box(-1.0, 1.0, self.least.shape, np.float64)
            self.middle, self.reach = (self.most + self.least) / 2, (self.most - self.least) / 2
        else:
            self.action_space = spaces.Box(self.least, self.most, dtype=np.float64)
        self.observation_space = spaces.Box(low, high, dtype=np.float64)
        self.message, self.ended_at = "", None  # type: str, float | None
        self.over = True

    @pythons_words()
    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None
              ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode; `options` has values for this one only, in the form and in the place of `values`;
        they change no draw of another episode.

        Raises UsageError for values that do not fit, and where the first observation is not within its limits; RunError
        if an FMU refuses to start.
        """
        super().reset(seed=seed)
        self.over, self.message, self.ended_at = True, "", None
        values = {name: drawn(name, draw, self.np_random) for name, draw in self.draws.items()}  # also those replaced
        if options:  # from numbers of their own: later episodes draw what they would without them
            apart, = self.np_random.spawn(1)
            values |= {name: drawn(name, draw, apart) for name, draw in options.items()}
        row = self.flown.begin(values)
        places = self.flown.places
        self.shown = np.array([places[port.name] for port in self.observations])
        self.now = Moment(places, row.tolist(), self.flown.time)
        self.observation = row.take(self.shown)
        if outside := self.outside(self.observation):
            raise UsageError(f"{outside}. Give other limits, as observations={{name: (low, high)}}.")
        self.over = False
        return self.observation.copy(), {"time": self.now.time, "message": "", "values": values}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Act for an advance: observation, reward, terminated, truncated, info, see the class.

        Raises UsageError for an action of another shape or with a number that is not finite, which no FMU sees, and
        after the end of an episode.
        """
        if self.over:
            raise UsageError("The episode is over, or did not begin: reset the environment.")
        inputs = self.inputs(action)
        lost, row = False, self.flown.row
        try:
            row = self.flown.advance(inputs)
        except Ended as end:
            self.message, self.ended_at, row = str(end), end.time, self.flown.row
        except RunError as error:
            self.message, lost = str(error), True
        observation = row.take(self.shown)
        if outside := self.outside(observation):
            self.message, lost, observation = f"{outside}.", True, self.observation
        self.observation = observation
        before = self.now
        before.before = None  # no chain of all that was
        self.now = now = Moment(before.places, before.row if lost else row.tolist(), self.flown.time, before)
        terminated = bool(self.message) or (self.terminated is not None and bool(self.terminated(now)))
        truncated = self.flown.done and not terminated
        self.over = terminated or truncated
        reward = (0.0 if self.reward is None else float(self.reward(now))) - (self.penalty if lost else 0.0)
        return observation.copy(), reward, terminated, truncated, {"time": now.time, "message": self.message}

    def inputs(self, action: np.ndarray) -> np.ndarray:
        """What an action, shape (actions,), gives to the inputs, in their units, shape (actions,).

        Raises UsageError for another shape, and for a number that is not finite.
        """
        found = np.asarray(action, np.float64)
        if found.shape != self.least.shape:
            raise UsageError(f"An action of shape {found.shape} is not allowed: it must be {self.least.shape}, for "
                             f"{', '.join(port.name for port in self.actions)}.")
        if not all(map(isfinite, found.tolist())):
            port, value = next((p, x) for p, x in zip(self.actions, found.tolist()) if not isfinite(x))
            raise UsageError(f"The action for {port.name} is {value}; it must be a finite number.")
        found = np.minimum(np.maximum(self.middle + self.reach * found, self.least), self.most)
        return np.where(self.whole, np.rint(found), found) if self.rounds else found

    def outside(self, observation: np.ndarray) -> str:
        """Which observation is not within its limits, a sentence without its full stop; empty if all are."""
        values = observation.tolist()  # in this size quicker than arrays; nan is not within, either
        if all(map(le, self.lows, values)) and all(map(ge, self.highs, values)):
            return ""
        port, value = next((p, x) for p, x in zip(self.observations, values) if not p.low <= x <= p.high)
        return f"At t = {self.flown.time:.6g} s {port.name} is {value:g}, beyond its limits ({port})"

    @property
    def flight(self) -> Flight:
        """The episode until now as a Flight: observations, actions and `signals`. Raises UsageError before the first
        reset."""
        return self.flown.flight(self.message, self.ended_at)

    def close(self) -> None:
        """End and unload the FMUs. It may be called again."""
        self.over = True
        self.flown.close()
        self.stack.close()


gymnasium.register("cosim/System-v0", f"{__name__}:{Environment.__name__}")
