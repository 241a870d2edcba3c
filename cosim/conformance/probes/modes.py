"""Probes of the modes that FMI 3.0 alone has: event mode and configuration mode. All calls are legal."""
from ..fmi2 import WARNING
from ..fmi3 import Instance3, Library3
from .bench import Bench
from .registry import NoInstance, probe, status_name

MOST_ROUNDS = 100  # of event iteration


@probe("event-mode", versions=("3.0",))
def event_mode(bench: Bench) -> None:
    """2.3.5, 4.2.1: with event mode used, discrete states are updated after initialization and at events."""
    if not bench.job.claims.get("hasEventMode"):
        bench.skip("event mode", "not claimed (hasEventMode)")
        return
    if bench.job.clocks:
        bench.skip("everything else dynamic", "the FMU has clocks, which this check does not tick")
    assert isinstance(bench.library, Library3)
    fmu = bench.library.instantiate("checked", bench.job.guid, bench.job.resources, event_mode=True)
    if fmu is None:
        raise NoInstance
    try:
        bench.initialize(fmu)
        if bench.job.clocks == "timed":
            return  # a master would have to tick them now
        if not leaves_events(bench, fmu, "after initialization"):
            return
        for number in range(bench.steps):
            bench.step(fmu, number)
            if fmu.event_needed or number == bench.steps // 2:  # a master may enter it at any communication point
                where = f"at time {bench.time(number + 1):g}"
                if not works(bench, fmu, "EnterEventMode", where) or not leaves_events(bench, fmu, where):
                    return
        bench.expect(fmu.call("Terminate"), "fmi2Terminate", "after the last step")
    finally:
        fmu.free()


def works(bench: Bench, fmu: Instance3, call: str, where: str) -> bool:
    """Call a function of event mode; whether it worked, which is reported if not."""
    status = fmu.call(call)
    if status > WARNING:
        bench.fault("dynamic.event-mode", f"fmi3{call}", f"{status_name(status)} {where}", "fmi3OK")
    return status <= WARNING


def leaves_events(bench: Bench, fmu: Instance3, where: str) -> bool:
    """From event mode to step mode; whether it worked."""
    for _ in range(MOST_ROUNDS):
        status, again = fmu.update_discrete_states()
        if status > WARNING:
            bench.fault("dynamic.event-mode", "fmi3UpdateDiscreteStates", f"{status_name(status)} {where}", "fmi3OK")
            return False
        if not again:
            return works(bench, fmu, "EnterStepMode", where)
    bench.fault("dynamic.event-mode", "fmi3UpdateDiscreteStates",
                f"discreteStatesNeedUpdate after {MOST_ROUNDS} rounds {where}", "an end of the iteration")
    return False


@probe("configuration", versions=("3.0",))
def configuration(bench: Bench) -> None:
    """2.3.6: structural parameters can be set, here to their start values, in configuration mode."""
    structural = [v for v in bench.job.variables if v.causality == "structuralParameter"]
    if not structural:
        return
    with bench.instance() as fmu:
        for call, v in (("EnterConfigurationMode", None), *((f"Set{v.base}", v) for v in structural),
                        ("ExitConfigurationMode", None)):
            status = fmu.call(call) if v is None else fmu.set(v.base, [v.reference], [v.start])
            if status > WARNING:
                words = f": '{bench.library.words}'" if bench.library.words else ""
                found = f"{status_name(status)} between the state instantiated and configuration mode{words}"
                bench.fault("dynamic.configuration", f"fmi3{call}", found, "fmi3OK")
                return
        bench.run(fmu, excite=False)
