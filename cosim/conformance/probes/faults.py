"""Probes of what an FMU does when a master makes mistakes: calls and values that the standard does not allow.

FMI 2.0 makes the master responsible for these calls, so most findings are warnings or notes. An FMU that refuses them
is easier to trust, and one that crashes ends its master as well.
"""
import math
from collections.abc import Callable
from functools import partial

from ..fmi2 import ERROR, FATAL, WARNING, Instance, Value
from ..job import Known
from .bench import BASES, Bench, Row, set_all
from .life import may_set
from .registry import BOTH, probe, status_name


@probe("guid", legal=False)
def guid(bench: Bench) -> None:
    """2.1.5: the GUID serves to check that XML file and binary belong together."""
    wrong = "00000000-dead-beef-0000-000000000000"
    made = bench.library.instantiate("checked", wrong, bench.job.resources)
    if made is not None:
        made.free()
        bench.fault("dynamic.guid", "fmi2Instantiate", f"an instance for the wrong GUID '{wrong}'", "a null pointer")


def expect_refusal(bench: Bench, fmu: Instance, rule: str, call: str, act: Callable[[], int], where: str,
                   expected: str = "fmi2Error") -> int:
    """Make a wrong call, `act`, and report where it is done (a breach of `rule`), or refused badly; its status."""
    told = fmu.messages.total()
    status = act()
    if status <= WARNING:
        bench.fault(rule, call, f"{status_name(status)} {where}", expected)
    elif status == FATAL:
        bench.fault("dynamic.fatal", call, f"fmi2Fatal {where}", f"{expected}, and a usable FMU")
    if status > WARNING and fmu.messages.total() == told:
        bench.fault("dynamic.log-refusal", call, f"{status_name(status)} {where}, and no message", "a message")
    return status


def before_setup(bench: Bench, fmu: Instance) -> None:
    """Leave the instance as it is."""


def in_initialization(bench: Bench, fmu: Instance) -> None:
    """Bring the instance into initialization mode."""
    bench.expect(fmu.setup(bench.job.start), "fmi2SetupExperiment", "in the state instantiated")
    bench.expect(fmu.call("EnterInitializationMode"), "fmi2EnterInitializationMode", "after fmi2SetupExperiment")


def stepping(bench: Bench, fmu: Instance) -> None:
    """Bring the instance to the state after a first step."""
    bench.initialize(fmu)
    bench.step(fmu, 0)


def terminated(bench: Bench, fmu: Instance) -> None:
    """Bring the instance to the state after fmi2Terminate."""
    stepping(bench, fmu)
    bench.expect(fmu.call("Terminate"), "fmi2Terminate", "after a step")


def do_step(bench: Bench, fmu: Instance) -> int:
    """fmi2DoStep from the start; its status."""
    return fmu.step(bench.job.start, bench.job.step)


def plain(name: str, _bench: Bench, fmu: Instance) -> int:
    """fmi2`name`; its status."""
    return fmu.call(name)


def set_up(bench: Bench, fmu: Instance) -> int:
    """fmi2SetupExperiment; its status."""
    return fmu.setup(bench.job.start)


# FMI 2.0, section 4.2.4, the table of allowed calls: (what is called, in which state, how to get there, the call).
FORBIDDEN: tuple[tuple[str, str, Callable[[Bench, Instance], None], Callable[[Bench, Instance], int]], ...] = (
    ("fmi2DoStep", "instantiated", before_setup, do_step),
    ("fmi2ExitInitializationMode", "instantiated", before_setup, partial(plain, "ExitInitializationMode")),
    ("fmi2DoStep", "initialization mode", in_initialization, do_step),
    ("fmi2EnterInitializationMode", "initialization mode", in_initialization,
     partial(plain, "EnterInitializationMode")),
    ("fmi2SetupExperiment", "step complete", stepping, set_up),
    ("fmi2EnterInitializationMode", "step complete", stepping, partial(plain, "EnterInitializationMode")),
    ("fmi2DoStep", "terminated", terminated, do_step),
    ("fmi3EnterEventMode", "step complete, without event mode", stepping, partial(plain, "EnterEventMode")),
)


def try_forbidden(call: str, state: str, arrive: Callable, act: Callable, bench: Bench) -> None:
    """4.2.4: a call in a state that does not allow it returns fmi2Error."""
    with bench.instance() as fmu:
        arrive(bench, fmu)
        expect_refusal(bench, fmu, "dynamic.call-order", call, lambda: act(bench, fmu),
                       f"in the state '{state}', where the call is not allowed")


ONLY = {"fmi2SetupExperiment": ("2.0",), "fmi3EnterEventMode": ("3.0",)}
for _forbidden in FORBIDDEN:
    probe(f"call-order: {_forbidden[0]} when {_forbidden[1]}", legal=False,
          versions=ONLY.get(_forbidden[0], BOTH))(partial(try_forbidden, *_forbidden))


def try_step_size(size: float, rule: str, bench: Bench) -> None:
    """4.2.2: the communication step size must be above zero."""
    with bench.instance() as fmu:
        stepping(bench, fmu)
        expect_refusal(bench, fmu, rule, "fmi2DoStep", lambda: fmu.step(bench.time(1), size),
                       f"for a communication step of {size:g}", "fmi2Error: the step must be above 0")


for _name, _size in (("zero", 0.0), ("negative", -1e-3), ("nan", math.nan)):
    _rule = "dynamic.zero-step" if _name == "zero" else "dynamic.bad-step"
    probe(f"step-size: {_name}", legal=False)(partial(try_step_size, _size, _rule))


@probe("time: nan", legal=False)
def nan_time(bench: Bench) -> None:
    """4.2.2: a communication point is a number."""
    with bench.instance() as fmu:
        stepping(bench, fmu)
        expect_refusal(bench, fmu, "dynamic.bad-time", "fmi2DoStep", lambda: fmu.step(math.nan, bench.job.step),
                       "for the communication point nan")


def try_unknown(base: str, setting: bool, bench: Bench) -> None:
    """2.1.7: a value reference that no variable of this type has."""
    used = {v.reference for v in bench.job.variables}
    unknown = next(reference for reference in range(987654321, 2**31) if reference not in used)
    value: Value = b"" if base in ("String", "Binary") else 0
    with bench.instance() as fmu:
        stepping(bench, fmu)
        expect_refusal(bench, fmu, "dynamic.unknown-reference", f"fmi2{'Set' if setting else 'Get'}{base}",
                       lambda: fmu.set(base, [unknown], [value]) if setting else fmu.get(base, [unknown])[0],
                       f"for the value reference {unknown}, which no variable has")


for _base in dict.fromkeys(base for bases in BASES.values() for base in bases):
    for _setting in (False, True):
        _verb = "Set" if _setting else "Get"
        _versions = tuple(version for version, bases in BASES.items() if _base in bases)
        probe(f"unknown-reference: {_verb}{_base}", legal=False,
              versions=_versions)(partial(try_unknown, _base, _setting))


def forbidden_writes(bench: Bench) -> list[Known]:
    """One variable of each kind that may not be set between steps: the first of each causality and variability."""
    kinds: dict[tuple[str, str], Known] = {}
    for v in bench.job.variables:
        if not may_set(v, "step complete") and not v.is_text:
            kinds.setdefault((v.causality, v.variability), v)
    return list(kinds.values())


@probe("forbidden-write", legal=False)
def forbidden_write(bench: Bench) -> None:
    """2.2.7, 4.2.4: constants, fixed parameters, outputs and locals cannot be set between steps."""
    for v in forbidden_writes(bench):
        if bench.library.is_corrupt:
            bench.skip("setting what may not be set, further variables", "the FMU answered the first with fmi2Fatal")
            return
        with bench.instance() as fmu:
            stepping(bench, fmu)
            _, before = fmu.get(v.base, [v.reference])
            expect_refusal(bench, fmu, "dynamic.forbidden-write", v.name,
                           partial(fmu.set, v.base, [v.reference], before), f"of fmi2Set{v.base} between steps",
                           f"fmi2Error: a {v.variability} {v.causality}")


@probe("nonfinite", legal=False, many=True)
def nonfinite(bench: Bench) -> None:
    """2.1.7: NaN and infinite inputs do no lasting harm: after a reset the first run is there again."""
    if not bench.moving_inputs:
        bench.skip("non-finite inputs", "there is no Real input")
        return
    bench.prepare()
    for value in (math.nan, math.inf):
        with bench.instance() as fmu:
            if survives(bench, fmu, value):
                expect_first_run(bench, fmu, value)
        if bench.library.is_corrupt:
            return


def survives(bench: Bench, fmu: Instance, value: float) -> bool:
    """Set every Real input to the value and step; whether the instance can still be used."""
    bench.initialize(fmu)
    status = set_all(fmu, bench.moving_inputs, lambda _: value)
    if status == FATAL:
        bench.fault("dynamic.fatal", bench.moving_inputs[0].name, f"fmi2Fatal for {value:g}",
                    "fmi2Error or fmi2Discard, and a usable FMU")
    if status <= WARNING and fmu.step(bench.job.start, bench.job.step) <= WARNING:
        spoiled = [v.name for v, got in bench.values(bench.row(fmu)) if is_nonfinite(got)]
        if spoiled:
            found = f"{value:g} on the inputs gives fmi2OK and non-finite values ({len(spoiled)} variables)"
            bench.fault("dynamic.nonfinite-input", spoiled[0], found, "fmi2Error or fmi2Discard, or finite values")
    return not bench.library.is_corrupt


def is_nonfinite(value: Value) -> bool:
    """Whether a value is NaN or infinite."""
    return isinstance(value, float) and not math.isfinite(value)


def expect_first_run(bench: Bench, fmu: Instance, value: float) -> None:
    """Reset the FMU and compare its run with the first one."""
    bench.expect(fmu.call("Reset"), "fmi2Reset", f"after {value:g} on the inputs")
    rows: list[Row] = bench.run(fmu)
    if bench.is_deterministic:
        bench.judge("dynamic.nonfinite-reset", bench.difference(bench.first_run, rows), "the first run again",
                    f", in a run after {value:g} on the inputs and fmi2Reset")


@probe("stop-time", legal=False)
def stop_time(bench: Bench) -> None:
    """2.1.6: with a stop time defined, steps up to it work and a step beyond it returns fmi2Error."""
    bench.prepare()
    count = min(bench.steps, 5)
    with bench.instance() as fmu:
        bench.initialize(fmu, stop=bench.time(count))
        for number in range(count):
            status = fmu.step(bench.time(number), bench.job.step)
            if status > WARNING:
                found = f"{status_name(status)} for the step to {bench.time(number + 1):g}"
                expected = f"fmi2OK up to the stop time {bench.time(count):g}"
                bench.fault("dynamic.stop-early", "fmi2DoStep", found, expected)
                return
        where = f"for a step beyond the stop time {bench.time(count):g}"
        status = expect_refusal(bench, fmu, "dynamic.stop-time", "fmi2DoStep",
                                lambda: fmu.step(bench.time(count), bench.job.step), where)
        if status > WARNING and status != ERROR:
            bench.fault("dynamic.stop-time", "fmi2DoStep", f"{status_name(status)} {where}", "fmi2Error")
