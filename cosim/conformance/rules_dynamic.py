"""The rules that need the FMU to run, as data; the probes (probes_*.py) find what breaks them."""

from __future__ import annotations

from cosim.conformance.rules import ERROR, NOTE, WARNING, declare

DYNAMIC_RULES = tuple(
    declare(f"dynamic.{name}", section, severity, summary)
    for name, section, severity, summary in (
        ("load", "2.3", ERROR, "The binary for this platform can be loaded."),
        ("version", "2.1.4", ERROR, "fmi2GetVersion returns 2.0."),
        ("types-platform", "2.1.4", WARNING, "fmi2GetTypesPlatform returns default."),
        ("crash", "2.1.3", ERROR, "No call ends the process; problems are told by the returned status."),
        ("hang", "2.1.3", ERROR, "Every call returns within the time limit."),
        ("instantiate", "2.1.5", ERROR, "fmi2Instantiate gives an instance for the GUID of the XML file."),
        ("second-instance", "4.3.1", ERROR, "A second instance exists beside the first, unless that is ruled out."),
        ("isolation", "4.3.1", ERROR, "An instance gives the same bits whatever another instance does."),
        ("legal-call", "4.2.4", ERROR, "A call that the state machine allows works."),
        ("read", "2.1.7", ERROR, "Every variable can be read in every mode where that is allowed."),
        ("string", "2.1.7", ERROR, "String values are UTF-8, not null pointers."),
        ("write", "2.1.7", ERROR, "Every variable that may be set can be set to its start value."),
        ("write-ignored", "2.1.7", WARNING, "A parameter or input that was set holds that value."),
        ("start-value", "2.2.7", ERROR, "Start values in the XML file and in the binary agree."),
        ("data-changes", "2.2.7", ERROR, "Constant, fixed and untouched tunable variables keep their values."),
        ("time", "2.2.7", ERROR, "The independent variable is the time of the communication point."),
        ("finite", "2.1.7", WARNING, "Values are finite in a run with all inputs at their start values."),
        ("range", "2.2.3", WARNING, "Booleans, enumerations and integers are in range (Reals: a note)."),
        ("deterministic", "2.1.6", WARNING, "Two fresh instances give the same bits."),
        ("reset-replay", "2.1.6", ERROR, "After fmi2Reset the first run is there again."),
        ("varying-steps", "4.3.1", ERROR, "Steps of varying size work where they are claimed."),
        ("state-replay", "2.1.8", ERROR, "A restored state replays to the last bit."),
        ("state-free", "2.1.8", NOTE, "fmi2FreeFMUstate returns a null pointer."),
        ("serialize-replay", "2.1.8", ERROR, "A state that was serialized replays to the last bit."),
        ("directional", "2.1.9", ERROR, "Directional derivatives work where they are claimed."),
        ("input-derivatives", "4.2.1", ERROR, "Derivatives of inputs can be set where interpolation is claimed."),
        ("output-derivatives", "4.2.1", ERROR, "Derivatives of outputs can be read where they are claimed."),
        ("log-off", "2.1.5", NOTE, "Nothing but problems is logged when logging is off."),
        ("log-category", "2.2.4", WARNING, "Messages have one of the listed log categories."),
        ("memory", "2.1.5", WARNING, "Neither lives of an instance nor steps need ever more memory."),
        ("handles", "2.1.5", WARNING, "fmi2FreeInstance closes all files."),
        ("guid", "2.1.5", NOTE, "fmi2Instantiate refuses another GUID."),
        ("call-order", "4.2.4", NOTE, "Calls that the state machine does not allow are refused."),
        ("zero-step", "4.2.2", NOTE, "A communication step of zero is refused."),
        ("bad-step", "4.2.2", WARNING, "A negative or undefined communication step is refused."),
        ("unknown-reference", "2.1.7", WARNING, "A value reference that no variable has is refused."),
        ("forbidden-write", "2.2.7", WARNING, "Variables that may not be set between steps cannot be set."),
        ("nonfinite-input", "2.1.7", NOTE, "NaN on an input does not silently give NaN on outputs."),
        ("nonfinite-reset", "2.1.6", ERROR, "fmi2Reset also brings back the start after non-finite inputs."),
        ("stop-time", "2.1.6", WARNING, "A step beyond the defined stop time returns fmi2Error."),
        ("stop-early", "2.1.6", WARNING, "Steps up to the defined stop time work."),
    )
)
