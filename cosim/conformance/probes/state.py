"""Probes of the capabilities that an FMU claims (4.3.1), and of memory and files that it does not give back."""
import gc
import mmap
import time
from collections.abc import Callable, Iterable
from ctypes import c_void_p
from itertools import pairwise
from pathlib import Path

from ..fmi2 import WARNING, Instance
from ..job import Known
from .bench import Bench, Row, probe, status_name

WARM_UP = 50  # cycles after which caches are filled
SMALL_LEAK = 512  # bytes for each life: less is what allocators make of nothing
LARGE_LEAK = 16 * 1024  # bytes for each life: up to here a thousand lives cost a host 16 MB, which is worth a note
STEP_LEAK = 64  # bytes for each step
LEAST = 256 * 1024  # bytes altogether: less is not measured reliably


def is_continuous_output(v: Known) -> bool:
    """Whether the variable is a continuous output of type Real."""
    return (v.base, v.causality, v.variability) == ("Real", "output", "continuous")


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
        for share in (1.0, 0.5, 0.25, 1.0, 0.1, 0.65):
            status = fmu.step(now, share * bench.job.step)
            if status > WARNING:
                found = f"fmi2DoStep of {share:g} times the preferred step returned {status_name(status)}"
                bench.fault("dynamic.varying-steps", "fmi2DoStep", found, "fmi2OK")
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
    for _ in range(2):
        bench.expect(fmu.set_state(saved), "fmi2SetFMUstate", "after further steps")
        replay: list[Row] = bench.advance(fmu, half, bench.steps)
        different = bench.difference(original, replay, offset=half)
        if different and bench.is_deterministic:
            bench.fault(rule, different.variable, different.text, "the same bits as before")
            return


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


@probe("input-derivatives")
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


@probe("asynchronous")
def asynchronous(bench: Bench) -> None:
    """4.2.2 canRunAsynchronuously is never tested: no master at hand uses it."""
    why = "claimed, but not tested by this checker" if bench.job.claims.get("canRunAsynchronuously") else "not claimed"
    bench.skip("asynchronous steps", f"{why} (canRunAsynchronuously)")


@probe("memory", many=True)
def memory(bench: Bench) -> None:
    """2.1.5: fmi2FreeInstance frees all memory and other resources, seen over many lives of an instance."""
    handles = open_handles()
    grown, done = growth(bench, lambda: life(bench), "lives of an instance")
    if grown > max(SMALL_LEAK * done, LEAST):
        severity = "note" if grown < LARGE_LEAK * done else None
        found = f"{grown // done} bytes more for each of {done} lives"
        bench.fault("dynamic.memory", "fmi2FreeInstance", found, "all memory is freed", severity)
    if done and open_handles() - handles >= done:
        found = f"{open_handles() - handles} more open files after {done} lives"
        bench.fault("dynamic.handles", "fmi2FreeInstance", found, "as many as before")


@probe("memory-steps")
def memory_steps(bench: Bench) -> None:
    """2.1.5: stepping does not need ever more memory, seen over many runs of one instance."""
    with bench.instance() as fmu:
        grown, done = growth(bench, lambda: rerun(bench, fmu), "runs with resets between")
    steps = done * bench.steps
    if grown > max(STEP_LEAK * steps, LEAST):
        found = f"{grown // steps} bytes more for each of {steps} steps"
        bench.fault("dynamic.memory", "fmi2DoStep", found, "no growth from step to step")


def life(bench: Bench) -> None:
    """One short life of an instance."""
    with bench.instance() as fmu:
        bench.initialize(fmu)
        bench.step(fmu, 0)
        bench.expect(fmu.call("Terminate"), "fmi2Terminate", "after a step")


def rerun(bench: Bench, fmu: Instance) -> None:
    """One run of an instance, then fmi2Reset."""
    bench.initialize(fmu)
    for number in range(bench.steps):
        bench.step(fmu, number)
    bench.expect(fmu.call("Reset"), "fmi2Reset", "after a step")


def growth(bench: Bench, once: Callable[[], None], what: str) -> tuple[int, int]:
    """Do something `cycles` times, or as often as time allows; return by how many bytes it grew, and how often it was.

    A leak grows in both halves alike, a cache in the first half only: what counts is twice the lesser growth.
    """
    if not Path("/proc/self/statm").exists():
        bench.skip(f"memory over many {what}", "this system has no /proc")
        return 0, 0
    deadline = time.monotonic() + bench.job.patience
    repeat(once, min(WARM_UP, bench.job.cycles), deadline)
    resident, done = [resident_bytes()], 0
    for _ in range(2):
        done += repeat(once, bench.job.cycles // 2, deadline)
        resident.append(resident_bytes())
    if done < bench.job.cycles:
        bench.skip(f"memory over {bench.job.cycles} {what}", f"slow: {done} were done in the time for that")
    return 2 * min(after - before for before, after in pairwise(resident)), done


def repeat(once: Callable[[], None], count: int, deadline: float) -> int:
    """Do something `count` times, or until the deadline; how often it was done."""
    for done in range(count):
        if time.monotonic() > deadline:
            return done
        once()
    return count


def resident_bytes() -> int:
    """The memory of this process."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE


def open_handles() -> int:
    """How many files this process has open; 0 where the system does not tell."""
    folder = Path("/proc/self/fd")
    return len(list(folder.iterdir())) if folder.exists() else 0
