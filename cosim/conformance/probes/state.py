"""Probes of the capabilities that an FMU claims (4.3.1)."""
from collections.abc import Iterable
from ctypes import c_void_p

from ..fmi2 import DISCARD, WARNING, Instance
from ..job import Known
from .bench import Bench, Row, moved, set_all
from .compare import bits
from .life import may_set
from .registry import probe, status_name


def is_continuous_output(v: Known) -> bool:
    """Whether the variable is a continuous output of type Real."""
    return (v.causality, v.variability) == ("output", "continuous") and v.base in ("Real", "Float64")


def is_claimed(bench: Bench, flag: str, what: str) -> bool:
    """Whether the FMU claims a capability; if not, `what` is reported as not tested."""
    if not bench.job.claims.get(flag):
        bench.skip(what, f"not claimed ({flag})")
        return False
    return True


@probe("varying-steps")
def varying_steps(bench: Bench) -> None:
    """4.3.1 canHandleVariableCommunicationStepSize: steps of varying size are done."""
    if not is_claimed(bench, "canHandleVariableCommunicationStepSize", "steps of varying size"):
        return
    bench.prepare()
    with bench.instance() as fmu:
        bench.initialize(fmu)
        now = bench.job.start
        for share in (1.0, 0.5, 0.25, 1.0, 0.1, 0.65) if not bench.job.fixed_step else (1.0, 2.0, 1.0, 3.0):
            status = fmu.step(now, share * bench.job.step)
            if status > WARNING:
                found = f"fmi2DoStep of {share:g} times the preferred step returned {status_name(status)}"
                severity = "warning" if status == DISCARD else None  # a slave may discard a step (4.2.2)
                bench.fault("dynamic.varying-steps", "fmi2DoStep", found, "fmi2OK", severity)
                return
            now += share * bench.job.step


@probe("state")
def state(bench: Bench) -> None:
    """2.1.8 canGetAndSetFMUstate: a state that was saved and set again replays to the last bit, more than once."""
    if not is_claimed(bench, "canGetAndSetFMUstate", "saving and restoring the FMU's state"):
        return
    bench.prepare()
    with bench.instance() as fmu:
        saved = saved_half_way(bench, fmu)
        compare_replays(bench, fmu, saved, "dynamic.state-replay")
        bench.expect(fmu.free_state(saved), "fmi2FreeFMUstate", "of a saved state")
        if saved.value:
            found = "the pointer is not null afterwards"
            bench.fault("dynamic.state-free", "fmi2FreeFMUstate", found, "a null pointer is returned in FMUstate")
        bench.expect(fmu.free_state(c_void_p()), "fmi2FreeFMUstate", "of a null pointer")


@probe("serialize")
def serialize(bench: Bench) -> None:
    """2.1.8 canSerializeFMUstate: a state that went through bytes replays to the last bit."""
    if not is_claimed(bench, "canSerializeFMUstate", "serializing the FMU's state"):
        return
    bench.prepare()
    with bench.instance() as fmu:
        saved = saved_half_way(bench, fmu)
        status, data = fmu.serialize(saved)
        bench.expect(status, "fmi2SerializeFMUstate", "of a saved state")
        bench.expect(fmu.free_state(saved), "fmi2FreeFMUstate", "of a saved state")
        status, restored = fmu.deserialize(data)
        bench.expect(status, "fmi2DeSerializeFMUstate", "of serialized bytes")
        compare_replays(bench, fmu, restored, "dynamic.serialize-replay")
        bench.expect(fmu.free_state(restored), "fmi2FreeFMUstate", "of a deserialized state")


def saved_half_way(bench: Bench, fmu: Instance) -> c_void_p:
    """Fly half a run; the state saved there."""
    bench.initialize(fmu)
    bench.advance(fmu, 0, bench.steps // 2)
    status, saved = fmu.get_state()
    bench.expect(status, "fmi2GetFMUstate", "after a step")
    return saved


def compare_replays(bench: Bench, fmu: Instance, saved: c_void_p, rule: str) -> None:
    """Go on from here, then twice from the saved state: all three must agree."""
    half = bench.steps // 2
    original = bench.advance(fmu, half, bench.steps)
    found = []
    for _ in range(2):
        bench.expect(fmu.set_state(saved), "fmi2SetFMUstate", "after further steps")
        replay: list[Row] = bench.advance(fmu, half, bench.steps)
        found.append(bench.difference(original, replay, offset=half))
    if bench.is_deterministic:
        bench.judge(rule, max(filter(None, found), key=lambda d: d.share, default=None), "the same values as before")


@probe("state-values")
def state_values(bench: Bench) -> None:
    """2.1.8: a state holds inputs and parameters too: changed after saving, they are back once it is restored."""
    if not bench.job.claims.get("canGetAndSetFMUstate"):
        return
    with bench.instance() as fmu:
        bench.initialize(fmu)
        bench.step(fmu, 0)
        wanted = [v for v in bench.job.variables if may_set(v, "step complete") and not v.is_text]
        changed = [v for v in wanted if set_all(fmu, [v], lambda e: other_value(e, 0.3)) <= WARNING]
        if bench.job.version != "2.0" and (changed != wanted or not reads_after_setting(bench, fmu, 1)):
            return
        before = bench.readings(fmu, changed)
        status, saved = fmu.get_state()
        bench.expect(status, "fmi2GetFMUstate", "after inputs were set")
        for v in changed:
            bench.expect(set_all(fmu, [v], lambda e: other_value(e, 0.9)), f"fmi2Set{v.base}", f"on '{v.name}'")
        bench.expect(fmu.set_state(saved), "fmi2SetFMUstate", "after inputs were changed")
        for (v, old), (_, new) in zip(before, bench.readings(fmu, changed), strict=False):
            if bits(old) != bits(new):
                found = f"{new!r} after fmi2SetFMUstate; it was {old!r} when the state was saved"
                bench.fault("dynamic.state-values", v.name, found, "the value of the saved state")
        bench.expect(fmu.free_state(saved), "fmi2FreeFMUstate", "of a saved state")


def reads_after_setting(bench: Bench, fmu: Instance, number: int) -> bool:
    """Make what was set readable: FMI 3.0 asks for a step between setting and reading (4.2.1). Whether it worked."""
    return fmu.step(bench.time(number), bench.job.step) <= WARNING


def other_value(v: Known, share: float) -> float:
    """A value for a variable: a Real a little off its start, another whole number for another `share`."""
    if v.is_real:
        return moved(v, share)
    if v.base == "Boolean":
        return int(share > 0.5)
    choices = v.items or [x for x in (int(v.start or 0), int(v.start or 0) + 1) if v.high is None or x <= v.high]
    return choices[-1] if share > 0.5 else choices[0]


@probe("directional")
def directional(bench: Bench) -> None:
    """2.1.9 providesDirectionalDerivative: fmi2GetDirectionalDerivative works from inputs to outputs."""
    if not is_claimed(bench, "providesDirectionalDerivative", "directional derivatives"):
        return
    outputs = [v for v in bench.job.variables if is_continuous_output(v)]
    with bench.instance() as fmu:
        bench.initialize(fmu)
        bench.step(fmu, 0)
        for known in bench.moving_inputs:
            for unknown in outputs:
                status, _ = fmu.directional(unknown.reference, known.reference)
                if status > WARNING:
                    found = f"fmi2GetDirectionalDerivative by '{known.name}' returned {status_name(status)}"
                    bench.fault("dynamic.directional", unknown.name, found, "fmi2OK")
                    return


@probe("input-derivatives", versions=("2.0",))
def input_derivatives(bench: Bench) -> None:
    """4.2.1 canInterpolateInputs: derivatives of continuous inputs can be set."""
    if not is_claimed(bench, "canInterpolateInputs", "derivatives of inputs"):
        return
    with bench.instance() as fmu:
        bench.initialize(fmu)
        inputs = [v for v in bench.moving_inputs if v.variability == "continuous"]
        answers = ((v, fmu.input_derivative(v.reference, 0.0)) for v in inputs)
        report_refusal(bench, "dynamic.input-derivatives", "fmi2SetRealInputDerivatives", answers)


@probe("output-derivatives")
def output_derivatives(bench: Bench) -> None:
    """4.2.1 maxOutputDerivativeOrder: first derivatives of continuous outputs can be read after a step."""
    if not is_claimed(bench, "maxOutputDerivativeOrder", "derivatives of outputs"):
        return
    with bench.instance() as fmu:
        bench.initialize(fmu)
        bench.step(fmu, 0)
        answers = ((v, fmu.output_derivative(v.reference)) for v in bench.job.variables if is_continuous_output(v))
        report_refusal(bench, "dynamic.output-derivatives", "fmi2GetRealOutputDerivatives", answers)


def report_refusal(bench: Bench, rule: str, call: str, answers: Iterable[tuple[Known, int]]) -> None:
    """Report the first of (variable, status) whose status says that the call failed; no further call is made."""
    for v, status in answers:
        if status > WARNING:
            bench.fault(rule, v.name, f"{call} returned {status_name(status)}", "fmi2OK")
            return


@probe("asynchronous", versions=("2.0",))
def asynchronous(bench: Bench) -> None:
    """4.2.2 canRunAsynchronuously is never tested: no master at hand uses it."""
    why = "claimed, but not tested by this checker" if bench.job.claims.get("canRunAsynchronuously") else "not claimed"
    bench.skip("asynchronous steps", f"{why} (canRunAsynchronuously)")
