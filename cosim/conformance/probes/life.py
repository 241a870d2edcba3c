"""Probes of what every FMU must be able to do: load, live, be read, be written, start again. All calls are legal."""
import math
import time

from ..fmi2 import WARNING, Instance, Value
from ..job import Known
from .bench import Bench, Row, moved, set_all
from .compare import BITS, bits
from .registry import Stopped, probe, status_name


@probe("load")
def load(bench: Bench) -> None:
    """2.1.4: the library loads and says which version it is of."""
    version = bench.library.text("GetVersion")
    if not version.startswith(bench.job.version):
        bench.fault("dynamic.version", "fmi2GetVersion", f"'{version}'", f"'{bench.job.version}'")
    platform = bench.library.text("GetTypesPlatform") if bench.job.version == "2.0" else "default"
    if platform != "default":
        bench.fault("dynamic.types-platform", "fmi2GetTypesPlatform", f"'{platform}'", "'default'")


@probe("life")
def life(bench: Bench) -> None:
    """4.2.4: a whole life with inputs at their start values, and a second one after a reset in initialization mode."""
    began = time.monotonic()
    with bench.instance() as fmu:
        bench.run(fmu, excite=False)
        bench.expect(fmu.call("Terminate"), "fmi2Terminate", "after the last step")
    bench.take_fewer_steps(time.monotonic() - began)


@probe("free-null")
def free_null(bench: Bench) -> None:
    """2.1.5: fmi2FreeInstance ignores a null pointer."""
    bench.library.free(None)


@probe("start-values")
def start_values(bench: Bench) -> None:
    """2.2.7: constants, parameters, inputs and what has initial "exact" begin with the start value of the XML file."""
    exact = [v for v in bench.job.variables if v.start is not None and (v.causality == "input" or (
             v.initial == "exact" and (v.variability != "discrete" or v.causality == "parameter")))]
    with bench.instance() as fmu:
        bench.initialize(fmu)
        for v, value in bench.readings(fmu, exact):
            if not same(value, v.start):
                bench.fault("dynamic.start-value", v.name, f"{shown(value)} after initialization", shown(v.start))


def same(value: Value, start: Value) -> bool:
    """Whether a value is the start value, as far as its text in the XML file tells."""
    if isinstance(value, float) and isinstance(start, (int, float)):
        return math.isclose(value, start, rel_tol=1e-6, abs_tol=1e-12)  # the XML may hold fewer digits
    return shown(value) == shown(start)


def shown(value: Value) -> str:
    """A value as text."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


@probe("read")
def read(bench: Bench) -> None:
    """2.1.7, 4.2.4: outputs in initialization mode, everything between steps and after fmi2Terminate."""
    with bench.instance() as fmu:
        bench.expect(fmu.setup(bench.job.start), "fmi2SetupExperiment", "in the state instantiated")
        bench.expect(fmu.call("EnterInitializationMode"), "fmi2EnterInitializationMode", "after fmi2SetupExperiment")
        outputs = [v for v in bench.job.variables if v.causality == "output"]
        read_each(bench, fmu, outputs, "in initialization mode")
        bench.expect(fmu.call("ExitInitializationMode"), "fmi2ExitInitializationMode", "in initialization mode")
        read_each(bench, fmu, bench.job.variables, "after initialization")
        bench.step(fmu, 0)
        read_each(bench, fmu, bench.job.variables, "after a step")
        bench.expect(fmu.call("Terminate"), "fmi2Terminate", "after a step")
        read_each(bench, fmu, bench.job.variables, "after fmi2Terminate")


@probe("read-start", versions=("3.0",))
def read_start(bench: Bench) -> None:
    """FMI 3.0, 2.3.2: start values can be read before initialization. Masters have the XML file for that: formal."""
    with bench.instance() as fmu:
        begun = [v for v in bench.job.variables if v.start is not None]
        read_each(bench, fmu, begun, "in the state instantiated", "formal")


def read_each(bench: Bench, fmu: Instance, variables: list[Known], where: str, impact: str | None = None) -> None:
    """Read variables one by one and report what is refused."""
    for v in variables:
        if bench.library.is_corrupt:
            return
        status, values = fmu.get(v.base, [v.reference])
        if status > WARNING:
            found = f"fmi2Get{v.base} returned {status_name(status)} {where}"
            bench.fault("dynamic.read", v.name, found, "fmi2OK", impact=impact)
            stop(bench)
        elif v.base == "String":
            for value in values:
                check_string(bench, v, value, where)


def stop(bench: Bench) -> None:
    """End the probe after a refusal, where no more calls are legal then. Raises Stopped."""
    if bench.job.version != "2.0":
        raise Stopped


def check_string(bench: Bench, v: Known, value: Value, where: str) -> None:
    """Report a null pointer, or bytes that are not UTF-8."""
    if value is None:
        bench.fault("dynamic.string", v.name, f"a null pointer {where}", "a string in UTF-8, perhaps empty")
    elif isinstance(value, bytes):
        try:
            value.decode("utf-8")
        except UnicodeDecodeError:
            bench.fault("dynamic.string", v.name, f"{value!r} {where}", "a string in UTF-8")


@probe("values")
def values(bench: Bench) -> None:
    """2.2.3, 2.2.7: values are what their type, their range and their variability allow."""
    numbers = [v for v in bench.job.variables if not v.is_text]
    with bench.instance() as fmu:
        bench.initialize(fmu)
        first = bench.readings(fmu, numbers)
        bench.advance(fmu, 0, bench.steps, excite=False)
        last = bench.readings(fmu, numbers)
    for (v, before), (_, after) in zip(first, last, strict=False):
        check_value(bench, v, after)
        if v.variability in ("constant", "fixed", "tunable") and bits(before) != bits(after):
            found = f"{before!r} after initialization, {after!r} after {bench.steps} steps"
            bench.fault("dynamic.data-changes", v.name, found, f"one value: the variable is {v.variability}")
        if v.causality == "independent" and isinstance(after, float):
            check_time(bench, v, after)


def check_time(bench: Bench, v: Known, value: float) -> None:
    """Report an independent variable that is not the time."""
    expected = bench.time(bench.steps)
    if abs(value - expected) > 1e-6 * max(bench.job.step, abs(expected)):
        bench.fault("dynamic.time", v.name, f"{value!r} after {bench.steps} steps", f"{expected:g}, the time")


def check_value(bench: Bench, v: Known, value: Value) -> None:
    """Report a value that is not finite, or that its type or range excludes."""
    if not isinstance(value, (int, float)):
        return
    if not math.isfinite(value):
        bench.fault("dynamic.finite", v.name, f"{value!r} in a run with all inputs at their start", "a finite number")
    elif v.base == "Boolean" and value not in (0, 1):
        bench.fault("dynamic.range", v.name, f"{value}", "fmi2False (0) or fmi2True (1)")
    elif v.items and value not in v.items:
        bench.fault("dynamic.range", v.name, f"{value}", f"one of {', '.join(map(str, v.items))}")
    elif is_outside(v, value):
        low = "-inf" if v.low is None else f"{v.low:g}"
        high = "inf" if v.high is None else f"{v.high:g}"
        severity = "note" if v.is_real else None  # for a Real, min and max are information (2.2.3)
        bench.fault("dynamic.range", v.name, f"{value!r}", f"{low} to {high}", severity)


def is_outside(v: Known, value: float) -> bool:
    """Whether a value lies outside of min and max."""
    slack = 1e-6 * max(abs(v.low or 0.0), abs(v.high or 0.0), 1e-3) if v.is_real else 0.0
    return (v.low is not None and value < v.low - slack) or (v.high is not None and value > v.high + slack)


def may_set(v: Known, mode: str) -> bool:
    """Section 4.2.4, footnotes of the table: which variables may be set in a mode."""
    if v.variability == "constant" or v.causality in ("independent", "structuralParameter"):
        return False
    if mode == "instantiated":
        return v.causality == "input" or v.initial in ("exact", "approx")
    if mode == "initialization mode":
        return v.causality == "input" or v.initial == "exact"
    return v.causality == "input" or (v.causality == "parameter" and v.variability == "tunable")


@probe("write")
def write(bench: Bench) -> None:
    """2.1.7, 4.2.4: what may be set can be set, to its start value, in each mode where that is allowed."""
    with bench.instance() as fmu:
        write_each(bench, fmu, "instantiated")
        bench.expect(fmu.setup(bench.job.start), "fmi2SetupExperiment", "in the state instantiated")
        bench.expect(fmu.call("EnterInitializationMode"), "fmi2EnterInitializationMode", "after fmi2SetupExperiment")
        write_each(bench, fmu, "initialization mode")
        bench.expect(fmu.call("ExitInitializationMode"), "fmi2ExitInitializationMode", "in initialization mode")
        write_each(bench, fmu, "step complete")
        bench.step(fmu, 0)
        write_each(bench, fmu, "step complete")


def write_each(bench: Bench, fmu: Instance, mode: str) -> None:
    """Set variables to their start values one by one and report what is refused."""
    for v in bench.job.variables:
        if v.start is None or not may_set(v, mode) or bench.library.is_corrupt:
            continue
        starts = [e.start.encode() if isinstance(e.start, str) else e.start for e in v.elements()]
        status = fmu.set(v.base, [v.reference], starts)
        if status > WARNING:
            found = f"fmi2Set{v.base} to {v.start!r} returned {status_name(status)} in mode '{mode}'"
            bench.fault("dynamic.write", v.name, found, "fmi2OK")
            stop(bench)


@probe("write-read")
def write_read(bench: Bench) -> None:
    """2.1.7: a Real parameter or input that was set before initialization holds that value after it."""
    candidates = [v for v in bench.job.variables if v.is_real and v.causality in ("parameter", "input")]
    with bench.instance() as fmu:
        targets = [v for v in candidates if set_all(fmu, [v], lambda e: moved(e, 0.5)) <= WARNING]
        bench.expect(fmu.setup(bench.job.start), "fmi2SetupExperiment", "in the state instantiated")
        if fmu.call("EnterInitializationMode") > WARNING or fmu.call("ExitInitializationMode") > WARNING:
            return  # the FMU need not bear these values
        for v, value in bench.readings(fmu, targets):
            if not same(value, moved(v, 0.5)):
                found = f"{value!r} after it was set to {moved(v, 0.5)!r} before initialization"
                bench.fault("dynamic.write-ignored", v.name, found, "the value that was set")


@probe("deterministic", many=True)
def deterministic(bench: Bench) -> None:
    """Two runs of two fresh instances give the same bits."""
    different = bench.difference(bench.first_run, bench.second_run)
    if different:
        severity = "note" if different.share < BITS else "warning"
        impact = "formal" if different.is_explained or not different.counts else None
        found = f"{different.text}; up to {different.share:.2g} of the variable's scale"
        bench.fault("dynamic.deterministic", different.variable, found, "the same bits in every run", severity, impact)
    if not bench.is_deterministic:
        bench.skip("replays (reset, restored state, other instances)", "two runs of the FMU differ anyway")


@probe("reset")
def reset(bench: Bench) -> None:
    """2.1.6: fmi2Reset brings back the state after fmi2Instantiate, so the second run is the first again."""
    bench.prepare()
    with bench.instance() as fmu:
        first = bench.run(fmu)
        bench.expect(fmu.call("Terminate"), "fmi2Terminate", "after the last step")
        bench.expect(fmu.call("Reset"), "fmi2Reset", "after fmi2Terminate")
        second = bench.run(fmu)
        bench.expect(fmu.call("Reset"), "fmi2Reset", "after a step")
        third = bench.run(fmu)
    if bench.is_deterministic:
        different = max(filter(None, (bench.difference(first, other) for other in (second, third))),
                        key=lambda d: d.share, default=None)
        bench.judge("dynamic.reset-replay", different, "the first run again")


@probe("twice", many=True)
def twice(bench: Bench) -> None:
    """2.1.5: two instances exist at a time, and neither sees what happens to the other."""
    bench.prepare()
    with bench.instance() as fmu:
        other = bench.library.instantiate("other", bench.job.guid, bench.job.resources)
        if other is None:
            bench.fault("dynamic.second-instance", "fmi2Instantiate", "a null pointer beside another", "an instance")
            return
        rows = interleaved(bench, fmu, other)
        other.free()
        rows += bench.advance(fmu, bench.steps // 2, bench.steps)
        different = bench.difference(bench.first_run, rows)
    if bench.is_deterministic:
        bench.judge("dynamic.isolation", different, "what it gives alone")


def interleaved(bench: Bench, fmu: Instance, other: Instance) -> list[Row]:
    """Half a run of `fmu`, while `other` is initialized with other values and steps in between."""
    for v in bench.job.variables:
        if v.is_real and v.causality in ("parameter", "input"):
            set_all(other, [v], lambda e: moved(e, 1.0))
    bench.initialize(fmu)
    other.setup(bench.job.start)
    alive = other.call("EnterInitializationMode") <= WARNING and other.call("ExitInitializationMode") <= WARNING
    rows = []
    for number in range(bench.steps // 2):
        alive = alive and other.step(bench.time(number), bench.job.step) <= WARNING
        rows += bench.advance(fmu, number, number + 1)
    return rows


@probe("logging")
def logging(bench: Bench) -> None:
    """2.1.5, 2.2.4: the listed log categories can be switched on, and no others are used."""
    with bench.instance() as fmu:
        bench.run(fmu, excite=False)
        chatter = {category: count for (status, category), count in fmu.messages.items() if status == 0}
        if chatter:
            found = f"{sum(chatter.values())} messages of status fmi2OK, categories {', '.join(sorted(chatter))}"
            bench.fault("dynamic.log-off", "fmi2Instantiate", found, "no such messages when loggingOn is fmi2False")
    with bench.instance(logging_on=True) as fmu:
        status = fmu.set_debug_logging(True, bench.job.categories)
        bench.expect(status, "fmi2SetDebugLogging", "with the categories of the XML file")
        bench.run(fmu, excite=False)
        unknown = sorted({category for _, category in fmu.messages} - set(bench.job.categories))
        if unknown and bench.job.categories:
            found = f"{len(unknown)} categories that are not listed: {', '.join(unknown)}"
            bench.fault("dynamic.log-category", unknown[0], found, "one of LogCategories")
    for what, found in bench.library.strange.items():
        bench.fault(f"dynamic.log-{what}", "logger", found, f"the instance's own {what}")
