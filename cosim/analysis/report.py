"""Any closed loop of FMU files linearised about the equilibrium that it flies to: what `linearize` gives, as plain data.

Each component is flown alone from that equilibrium, its answers to small pulses are measured (`pulses`) and made a state
space (`realise`), and these are connected as they fly (`connected`). What no input moves, or no output shows, is not
seen: states that are neither are in no poles. Neither is what only a signal that is no continuous Real carries.
"""
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import RunError, UsageError
from ..master.dependencies import step_order
from ..master.fmu import FmuFile
from ..master.loaded import open_files
from ..master.system import Connection, System
from ..master.wiring import checked_connections
from .connected import connected
from .margins import frequencies, margins, response
from .pulses import Answers, Rest, answers, at_rest, continuous_real, scale
from .realise import realise
from .statespace import StateSpace, continuous, nyquist, poles, roots, zeros

HORIZON = 1000   # ticks of an answer
AT_LIMIT = 1e-9  # of a variable's scale: a value this close to its minimum or maximum is there


def linearize(system: System, actuators: Sequence[str], sensors: Sequence[str], step: float, settle: float = 300.0,
              commands: Sequence[str] = (), horizon: int = HORIZON) -> dict[str, Any]:
    """Poles, zeros and margins of a closed loop of FMUs that holds still, flown in communication steps of `step` (s).

    Signals are outputs, as `component.variable`: the loop's `actuators` lead from controller to plant, its `sensors`
    back; `commands` drive it. The loop is flown, with whatever constant commands it has, until it is at rest, at most
    `settle` seconds; components answer pulses for `horizon` ticks. The loop must be stable.

    Gives a dictionary; signals in it go by their variables' names where these differ, and by `component.variable` else:
        settled_at_s   when the loop was at rest (s)
        equilibrium    value of each connected signal then, by component.variable, in the FMUs' units
        open_loop      from the actuators to the outputs of what they drive up to the sensors: matrices (continuous, step_s
                       0, or sampled where no continuous system has these samples), poles, zeros ("actuator to sensor";
                       1/s, up to half the sampling frequency)
        closed_loop    sampled, from the commands to sensors and actuators: matrices, stable, abscissa (largest real part
                       of a pole, 1/s), poles (1/s, of the continuous system with the same samples)
        margins        of each actuator and sensor, the others closed, as `margins.Margins`; None if it is not stable

    Raises UsageError for signals and numbers that do not fit the system; RunError, one sentence, where the loop departs,
    does not come to rest, has an actuator at a limit, or does not answer small pulses in proportion.
    """
    if not 0 < step < float("inf") or not step < settle < float("inf") or horizon < 100:
        raise UsageError(f"A step of {step:g} s, {settle:g} s to settle and a horizon of {horizon} steps do not go: the "
                         f"first is positive, the second longer, and the third at least 100.")
    with open_files(system) as files:
        links = [link for link in checked_connections(system, files).values() if moves(files, link)]
        for signal in (*actuators, *sensors, *commands):
            if all(signal != link.source for link in links):
                raise UsageError(f"{signal} is not a continuous Real output that is connected.")
        order = [n for group in step_order(system, files, {k.target: k for k in system.connections}) for n in group]
        links = live(links, [*actuators, *sensors], commands)
        rest = at_rest(system, files, sorted({link.source for link in links}), step, settle, horizon)
        for signal in actuators:
            check_limits(rest, signal, links)
        measured = {name: answered(rest, name, links, horizon) for name in order
                    if any(of(link.target) == name for link in links)}
    for signal in actuators:
        check_answer(measured, rest, signal)
    parts = {name: realise(name, found, step) for name, found in measured.items()}
    return {"settled_at_s": rest.ticks * step, "equilibrium": {k.source: rest.values[k.source] for k in links},
            **described(parts, links, actuators, sensors, commands)}


def of(signal: str) -> str:
    """The component that a signal belongs to."""
    return signal.partition(".")[0]


def moves(files: dict[str, FmuFile], link: Connection) -> bool:
    """Whether a connection carries a continuous Real."""
    return all(continuous_real(files[of(s)], s.partition(".")[2]) for s in (link.source, link.target))


def live(links: Sequence[Connection], signals: Iterable[str], commands: Iterable[str]) -> list[Connection]:
    """The connections through which `signals` or `commands` move anything."""
    moving = {of(signal) for signal in signals}
    while more := {of(k.target) for k in links if of(k.source) in moving or k.source in commands} - moving:
        moving |= more
    return [link for link in links if of(link.source) in moving or link.source in commands]


def check_limits(rest: Rest, signal: str, links: Sequence[Connection]) -> None:
    """Raise RunError if a signal is where the variable that shows it, or one that takes it, may go no further."""
    ends = [(signal, rest.values[signal]), *((k.target, k.factor * rest.values[signal] + k.offset)
                                             for k in links if k.source == signal)]
    for name, value in ends:
        file, variable = rest.files[of(name)], name.partition(".")[2]
        for word, limit in (("minimum", file.variable(variable).min), ("maximum", file.variable(variable).max)):
            if limit is not None and abs(value - float(limit)) <= AT_LIMIT * scale(file, variable, value):
                raise RunError(f"At rest the actuator {name} = {value:.6g} is at its {word}: "
                               f"there is nothing to linearise.")


def answered(rest: Rest, component: str, links: Sequence[Connection], horizon: int) -> Answers:
    inputs = [k.target.partition(".")[2] for k in links if of(k.target) == component]
    needed = sorted({k.source.partition(".")[2] for k in links if of(k.source) == component})
    return answers(rest, component, inputs, needed, horizon)


def check_answer(measured: dict[str, Answers], rest: Rest, signal: str) -> None:
    """Raise RunError if an actuator does not move with anything."""
    component, _, variable = signal.partition(".")
    found = measured.get(component)
    if found:
        row = found.outputs.index(variable)
        if np.any(np.abs(found.values[:, row]).max(axis=0) > found.errors[:, row].max(axis=0)):
            return
    raise RunError(f"At rest the actuator {signal} = {rest.values[signal]:.6g} answers no input of {component}: it is at a "
                   f"limit, or the loop is not closed through it.")


def driven(links: Sequence[Connection], actuators: Iterable[str], sensors: Iterable[str]) -> set[str]:
    """The components that actuators drive, as far as the sensors."""
    found = {of(k.target) for k in links if k.source in actuators}
    while more := {of(k.target) for k in links if of(k.source) in found and k.source not in sensors} - found:
        found |= more
    return found


def described(parts: dict[str, StateSpace], links: Sequence[Connection], actuators: Sequence[str],
              sensors: Sequence[str], commands: Sequence[str]) -> dict[str, Any]:
    """The open and the closed loop, and the margins, of linear parts."""
    plant = {name: part for name, part in parts.items() if name in driven(links, actuators, sensors)}
    others = [f"{name}.{output}" for name, part in plant.items() for output in part.outputs]
    alone = named(connected(plant, links, actuators, [*sensors, *(o for o in others if o not in sensors)]))
    smooth = continuous(alone) or alone
    closed = named(connected(parts, links, commands, [*sensors, *actuators]))
    stable = bool(np.abs(np.linalg.eigvals(closed.A)).max() < 1)
    found = {}
    if stable:
        omega = frequencies(closed.step)
        names = short([*actuators, *sensors])
        for signal in (*actuators, *sensors):
            cut = connected(parts, links, [signal], [signal])
            loop = -response(cut.A, cut.B, cut.C, cut.D, omega, cut.step)[:, 0, 0]
            found[names[signal]] = margins(omega, loop).as_dict()
    fastest = nyquist(closed.step)
    return {
        "open_loop": {**smooth.as_dict(), "poles": roots(poles(alone)),
                      "zeros": {f"{i} to {o}": roots(zeros(smooth, i, o), fastest)
                                for i in smooth.inputs for o in smooth.outputs[:len(sensors)]}},
        "closed_loop": {**closed.as_dict(), "stable": stable, "abscissa": float(poles(closed).real.max()),
                        "poles": roots(poles(closed))},
        "margins": found if stable else None,
    }


def short(signals: Sequence[str]) -> dict[str, str]:
    """component.variable -> the variable's name where that tells the signals apart."""
    names = [signal.partition(".")[2] for signal in signals]
    return {s: n if names.count(n) == 1 else s for s, n in zip(signals, names)}


def named(system: StateSpace) -> StateSpace:
    """The same with short names."""
    names = short(list(dict.fromkeys([*system.inputs, *system.outputs])))
    return replace(system, inputs=[names[n] for n in system.inputs], outputs=[names[n] for n in system.outputs])
