"""Any closed loop of FMU files, linearised about its equilibrium.

The loop is flown until it is at rest. Then each component is flown alone and its answers to small pulses are recorded
(`pulses`). One with a model-exchange interface is linearised from its equations (`equations`); these are taken if it
answers the pulses as they tell, and so flies as they say. Of any other a state space is found from its answers
(`realise`). All are connected as they fly (`connected`).

A loop that does not come to rest, such as an unstable one, is linearised from its equations alone if all components
have them: about the equilibrium that Newton's method finds (`balance`), as if each solved them exactly.

Limits of the method. A state that no input moves, or that no continuous Real output shows, is not found from answers;
nor is its pole. Connections of other types (Integer, Boolean, String, discrete Reals) stay as they are at rest. Poles
that decay to 1e-4 within one communication step are left out.
"""
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import RunError, UsageError
from ..master.connections import checked_connections
from ..master.dependencies import step_order
from ..master.fmu import FmuFile
from ..master.loaded import open_files
from ..master.system import Connection, System
from .balance import balanced
from .connected import connected
from .equations import Point, given, linearised
from .margins import margins_at
from .pulses import Answers, Rest, answers, at_rest, continuous_real
from .realise import realise
from .statespace import StateSpace, continuous, nyquist, poles, pulsed, roots, sampled, zeros_of_all

HORIZON = 1000   # ticks of an answer
ALIKE, CLOSE = 1e-8, 5.0  # of an answer's largest value until then, of its errors: a difference that is none
AT_LIMIT = 1e-9  # of a signal's scale: a value this close to its minimum or maximum is there


def linearize(system: System, actuators: Sequence[str], sensors: Sequence[str], step: float, settle: float = 300.0,
              commands: Sequence[str] = (), horizon: int = HORIZON) -> dict[str, Any]:
    """Poles, zeros and margins of a closed loop of FMUs, flown with Gauss-Seidel in steps of `step` seconds.

    Signals are connected outputs, as `component.variable`: `actuators` lead from the controller to the plant, `sensors`
    lead back, `commands` come from outside the loop and must be constant. The loop is flown until it is at rest, for at
    most `settle` seconds. Answers to pulses are recorded for `horizon` steps (at least 100).

    Returns a dictionary. In it a signal is called by its variable's name, or by `component.variable` if two of the
    signals given have the same variable name.
        settled_at_s   when the loop was found at rest, s; None where only Newton's method found its equilibrium
        solved         "as flown"; "exactly" if equations alone tell, which a component's own steps may solve otherwise
        equilibrium    values of the connected signals at rest, by component.variable, in the FMUs' units
        open_loop      from the actuators to all outputs of the components that they drive, as far as the sensors:
                       states, inputs, outputs, step_s, A, B, C, D (continuous with step_s 0; sampled if no continuous
                       system has these samples), poles, zeros (by "actuator to sensor", up to half the sampling
                       frequency), both in 1/s
        law            from the sensors and commands to the actuators, sampled: states, inputs, outputs, step_s, A, B,
                       C, D, poles, zeros; None if the loop is the plant alone
        closed_loop    from the commands to the sensors and actuators, sampled: states, inputs, outputs, step_s, A, B,
                       C, D, stable, abscissa (largest real part of a pole, 1/s), poles (1/s, of the continuous system
                       with the same samples)
        margins        for each actuator and sensor, with all others closed: the fields of `margins.Margins`

    Raises UsageError if a signal or a number does not fit. Raises RunError, with one sentence, if the loop departs or
    does not settle and no equilibrium of its equations is found, if an actuator is at a limit, or if a component's
    answers are not linear.
    """
    if not 0 < step < float("inf") or not step < settle < float("inf") or horizon < 100:
        raise UsageError(f"step = {step:g} s, settle = {settle:g} s and horizon = {horizon} do not fit: the step must "
                         f"be positive, settle longer than the step, and the horizon at least 100 steps.")
    if not actuators or not sensors:
        raise UsageError("A loop needs at least one actuator signal and one sensor signal to be linearised.")
    with open_files(system) as files:
        links = [link for link in checked_connections(system, files).values() if moves(files, link)]
        order = [n for group in step_order(system, files, {k.target: k for k in system.connections}) for n in group]
        links = live(links, [*actuators, *sensors], commands)
        check_signals(links, actuators, sensors, commands)
        try:
            rest = at_rest(system, files, sorted({link.source for link in links}), step, settle, horizon)
        except RunError as unsettled:
            if any(files[of(link.target)].description.model_exchange is None for link in links):
                raise
            rest, smooth = balanced_or(unsettled, system, files, links, order, step)
            for signal in actuators:
                check_limits(rest, signal, links)
                check_part(smooth, rest, signal)
            parts = {name: sampled(part, step) for name, part in smooth.items()}
        else:
            for signal in actuators:
                check_limits(rest, signal, links)
            parts, smooth = flown(rest, links, actuators, order, horizon)
    return {"settled_at_s": rest.ticks * step if rest.ticks else None,
            "solved": "as flown" if rest.ticks else "exactly",
            "equilibrium": {k.source: rest.values[k.source] for k in links},
            **described(parts, smooth, links, actuators, sensors, commands)}


def balanced_or(unsettled: RunError, *where: Any) -> tuple[Rest, dict[str, StateSpace]]:
    """What `balanced` finds. Raises RunError with both reasons if that is nothing."""
    try:
        return balanced(*where)
    except RunError as error:
        raise RunError(f"{str(unsettled).rstrip('.')}; {str(error).rstrip('.')}.") from None


def flown(rest: Rest, links: Sequence[Connection], actuators: Sequence[str], order: Sequence[str], horizon: int
          ) -> tuple[dict[str, StateSpace], dict[str, StateSpace]]:
    """The moving components at rest as they fly, sampled, in `order`; and the equations of those that fly as these
    tell. Raises RunError for what is not linear, or at a limit."""
    measured = {name: answered(rest, name, links, horizon) for name in order
                if any(of(link.target) == name for link in links)}
    for signal in actuators:
        check_answer(measured, rest, signal)
    known = {name: equations_at(rest, name, found) for name, found in measured.items()}
    smooth = {name: part for name, part in known.items() if part and flies_so(part, measured[name], rest.step)}
    return {name: sampled(smooth[name], rest.step) if name in smooth else realise(name, found, rest.step)
            for name, found in measured.items()}, smooth


def of(signal: str) -> str:
    """The component that a signal belongs to."""
    return signal.partition(".")[0]


def moves(files: dict[str, FmuFile], link: Connection) -> bool:
    """Whether a connection carries a continuous Real."""
    return all(continuous_real(files[of(s)], s.partition(".")[2]) for s in (link.source, link.target))


def reached(start: Iterable[str], arrows: Iterable[tuple[str, str]]) -> set[str]:
    """`start` and all that arrows lead to from there."""
    found, arrows = set(start), list(arrows)
    while more := {target for source, target in arrows if source in found} - found:
        found |= more
    return found


def live(links: Sequence[Connection], signals: Iterable[str], commands: Iterable[str]) -> list[Connection]:
    """The connections that carry a change from the components of `signals` or from `commands` back to `signals`."""
    own = {of(signal) for signal in signals}
    ahead = reached(own | {of(k.target) for k in links if k.source in commands},
                    ((of(k.source), of(k.target)) for k in links))
    behind = reached(own, ((of(k.target), of(k.source)) for k in links))
    return [k for k in links if of(k.target) in behind and (of(k.source) in ahead or k.source in commands)]


def check_signals(links: Sequence[Connection], actuators: Sequence[str], sensors: Sequence[str],
                  commands: Sequence[str]) -> None:
    """Raise UsageError for a signal that is not part of the loop, or a sensor that no actuator moves."""
    for signal in (*actuators, *sensors, *commands):
        if all(signal != link.source for link in links):
            raise UsageError(f"{signal} is not a continuous Real output that is connected within the loop.")
    for signal in sensors:
        if of(signal) not in driven(links, actuators, sensors):
            raise UsageError(f"The sensor {signal} shows nothing that an actuator drives: no connections lead from "
                             f"{', '.join(actuators)} to {of(signal)}.")


def check_limits(rest: Rest, signal: str, links: Sequence[Connection]) -> None:
    """Raise RunError if a signal is at the declared minimum or maximum of its own variable or of one it feeds."""
    ends = [(signal, rest.values[signal]), *((k.target, k.factor * rest.values[signal] + k.offset)
                                             for k in links if k.source == signal)]
    for name, value in ends:
        file, variable = rest.files[of(name)], name.partition(".")[2]
        for word, limit in (("minimum", file.variable(variable).min), ("maximum", file.variable(variable).max)):
            if limit is not None and abs(value - float(limit)) <= AT_LIMIT * rest.large[signal]:
                raise RunError(f"At rest the actuator {name} = {value:.6g} is at its {word}: the loop cannot be "
                               f"linearised there.")


def answered(rest: Rest, component: str, links: Sequence[Connection], horizon: int) -> Answers:
    """The answers of one component to pulses on its connected inputs."""
    inputs = [k.target.partition(".")[2] for k in links if of(k.target) == component]
    needed = sorted({k.source.partition(".")[2] for k in links if of(k.source) == component})
    return answers(rest, component, inputs, needed, horizon)


def equations_at(rest: Rest, component: str, found: Answers) -> StateSpace | None:
    """The equations of a component at rest, from the inputs to the outputs of its answers; None if it has none."""
    file = rest.files[component]
    if found.states is None:
        return None
    point = Point(given(rest.system, file, component, rest.values), found.states, rest.ticks * rest.step)
    system = linearised(file, point, found.inputs, found.outputs).system
    return replace(system, states=[f"{component}.{state}" for state in system.states])


def flies_so(smooth: StateSpace, found: Answers, step: float) -> bool:
    """Whether a component answers pulses as its equations do. It does not if it does not solve them as closely as its
    answers tell, or if it has more in it."""
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(pulsed(sampled(smooth, step), len(found.values)) - found.values)
    errors, reached = (np.maximum.accumulate(np.abs(part), axis=0) for part in (found.errors, found.values))
    return bool((off <= CLOSE * errors + ALIKE * reached).all())


def check_answer(measured: dict[str, Answers], rest: Rest, signal: str) -> None:
    """Raise RunError if an actuator does not answer any input of its component."""
    component, _, variable = signal.partition(".")
    found = measured.get(component)
    if found:
        row = found.outputs.index(variable)
        if np.any(np.abs(found.values[:, row]).max(axis=0) > found.errors[:, row].max(axis=0)):
            return
    raise RunError(stuck(rest, signal))


def check_part(parts: dict[str, StateSpace], rest: Rest, signal: str) -> None:
    """The same of equations: whether an actuator depends on any state or input of its component."""
    component, _, variable = signal.partition(".")
    part = parts.get(component)
    row = part.outputs.index(variable) if part else 0
    if part is None or not (part.C[row].any() or part.D[row].any()):
        raise RunError(stuck(rest, signal))


def stuck(rest: Rest, signal: str) -> str:
    """That an actuator does not answer, a sentence."""
    return (f"At rest the actuator {signal} = {rest.values[signal]:.6g} does not answer any input of {of(signal)}: it "
            f"is at a limit, or the loop is not closed through it.")


def driven(links: Sequence[Connection], actuators: Iterable[str], sensors: Iterable[str]) -> set[str]:
    """The components that actuators drive, as far as the sensors."""
    return reached((of(k.target) for k in links if k.source in actuators),
                   ((of(k.source), of(k.target)) for k in links if k.source not in sensors))


def described(parts: dict[str, StateSpace], equations: dict[str, StateSpace], links: Sequence[Connection],
              actuators: Sequence[str], sensors: Sequence[str], commands: Sequence[str]) -> dict[str, Any]:
    """The open and the closed loop, and the margins, of linear parts, sampled, and of the `equations` of some."""
    plant = {name: part for name, part in parts.items() if name in driven(links, actuators, sensors)}
    others = [o for name, part in plant.items() for o in (f"{name}.{v}" for v in part.outputs) if o not in sensors]
    names = short([*actuators, *sensors, *commands], others)
    alone = named(connected(plant, links, actuators, [*sensors, *others]), names)
    known = [equations[name] for name in plant if name in equations]
    exact = [driven_by(part, links, actuators, [*sensors, *others]) for part in known] if len(plant) == 1 else []
    smooth = named(exact[0], names) if exact else continuous(alone) or alone
    closed = named(connected(parts, links, commands, [*sensors, *actuators]), names)
    stable = bool(np.abs(np.linalg.eigvals(closed.A)).max() < 1)
    found = {names[signal]: margins_at(connected(parts, links, [signal], [signal])).as_dict()
             for signal in (*actuators, *sensors)} if stable else None
    fastest = nyquist(closed.step)
    rest = {name: part for name, part in parts.items() if name not in plant}
    seen = [s for s in [*sensors, *commands] if any(k.source == s and of(k.target) in rest for k in links)]
    law = named(connected(rest, links, seen, [s for s in actuators if of(s) in rest]), names) if rest else None
    return {
        "open_loop": {**smooth.as_dict(), "poles": roots(poles(smooth if exact else alone)),
                      "zeros": zeros_of_all(smooth, smooth.outputs[:len(sensors)], fastest)},
        "law": law and {**law.as_dict(), "poles": roots(poles(law)), "zeros": zeros_of_all(law, law.outputs, fastest)},
        "closed_loop": {**closed.as_dict(), "stable": stable, "abscissa": float(poles(closed).real.max()),
                        "poles": roots(poles(closed))},
        "margins": found,
    }


def short(signals: Sequence[str], others: Sequence[str]) -> dict[str, str]:
    """component.variable -> the variable's name where that tells it from the other signals; `others` give way."""
    names = [signal.partition(".")[2] for signal in signals]
    found = {s: n if names.count(n) == 1 else s for s, n in zip(signals, names)}
    more = [signal.partition(".")[2] for signal in others]
    return found | {s: n if [*names, *more].count(n) == 1 else s for s, n in zip(others, more)}


def named(system: StateSpace, names: dict[str, str]) -> StateSpace:
    """The same with other names of its inputs and outputs; states by their variables where these differ."""
    own = [state if state.endswith(" held") else state.partition(".")[2] or state for state in system.states]
    return replace(system, inputs=[names[n] for n in system.inputs], outputs=[names[n] for n in system.outputs],
                   states=[short if own.count(short) == 1 else full for short, full in zip(own, system.states)])


def driven_by(part: StateSpace, links: Sequence[Connection], actuators: Sequence[str], shown: Sequence[str]
              ) -> StateSpace:
    """A component alone, from `actuators` to the signals `shown`, which are its own."""
    gains = np.array([[sum(k.factor for k in links if k.source == signal and k.target.partition(".")[2] == name)
                       for signal in actuators] for name in part.inputs]).reshape(len(part.inputs), len(actuators))
    rows = [part.outputs.index(signal.partition(".")[2]) for signal in shown]
    return replace(part, B=part.B @ gains, C=part.C[rows], D=part.D[rows] @ gains, inputs=list(actuators),
                   outputs=list(shown))
