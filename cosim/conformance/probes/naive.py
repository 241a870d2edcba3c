"""Would a naive importer manage? Probes of what importers do that read the standard in a hurry."""
from ..fmi2 import WARNING
from .bench import Bench, set_all
from .registry import probe


@probe("naive-inputs", legal=False)
def naive_inputs(bench: Bench) -> None:
    """Some importers write zeros to all inputs before initialization ends: does the FMU bear that?"""
    inputs = bench.moving_inputs
    if not inputs or all(e.start in (None, 0.0) for v in inputs for e in v.elements()):
        return
    with bench.instance() as fmu:
        bench.expect(fmu.setup(bench.job.start), "fmi2SetupExperiment", "in the state instantiated")
        bench.expect(fmu.call("EnterInitializationMode"), "fmi2EnterInitializationMode", "after fmi2SetupExperiment")
        for name, act in (("fmi2SetReal", lambda: set_all(fmu, inputs, lambda _: 0.0)),
                          ("fmi2ExitInitializationMode", lambda: fmu.call("ExitInitializationMode")),
                          ("fmi2DoStep", lambda: fmu.step(bench.job.start, bench.job.step))):
            if act() > WARNING:
                bench.fault("naive.zero-inputs", name, "it fails after zeros on all inputs in initialization mode",
                            "an FMU that bears zeros, or start values from which it is seen that it does not")
                return
