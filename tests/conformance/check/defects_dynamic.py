"""Single defects of the binary: the rule that each breaks, and the macro of fixture.c that builds it."""

from typing import NamedTuple


class Defect(NamedTuple):
    rule: str
    macro: str
    what: str
    edits: tuple[str, str] | None = None  # what to replace in fixture.xml, by what


ZERO_INPUT = Defect("naive.zero-inputs", "ZERO_INPUT", "zeros on the inputs end the initialization",
                    ('max="10" start="0"', 'max="10" start="1"'))

DEFECTS = ZERO_INPUT, *(
    Defect(f"dynamic.{rule}", macro, what)
    for rule, macro, what in (
        ("load", "UNRESOLVED", "needs a function that no library has"),
        ("version", "VERSION", "fmi2GetVersion says 2.1"),
        ("types-platform", "TYPES_PLATFORM", "fmi2GetTypesPlatform says other"),
        ("limits", "SPOILS", "it writes to files that it did not open"),
        ("instantiate", "NO_INSTANCE", "fmi2Instantiate returns a null pointer"),
        ("second-instance", "ONE_INSTANCE", "a second instance is refused"),
        ("isolation", "SHARED", "instances share their values"),
        ("crash", "STEP_CRASHES", "fmi2DoStep aborts"),
        ("crash", "FREE_NULL", "fmi2FreeInstance aborts on a null pointer"),
        ("crash", "CRASH_ON_ORDER", "a call in the wrong mode aborts"),
        ("crash", "CRASH_ON_BAD_STEP", "a negative step aborts"),
        ("hang", "STEP_HANGS", "fmi2DoStep does not return"),
        ("legal-call", "EXIT_FAILS", "fmi2ExitInitializationMode fails"),
        ("legal-call", "STEP_FAILS", "fmi2DoStep fails"),
        ("legal-call", "STEP_DISCARDS", "fmi2DoStep discards a step"),
        ("legal-call", "STEP_PENDING", "fmi2DoStep is pending without being asynchronous"),
        ("legal-call", "TERMINATE_FAILS", "fmi2Terminate fails"),
        ("legal-call", "RESET_FAILS", "fmi2Reset fails"),
        ("legal-call", "STATE_FAILS", "fmi2GetFMUstate fails though claimed"),
        ("legal-call", "DESERIALIZE_FAILS", "fmi2DeSerializeFMUstate fails though claimed"),
        ("legal-call", "DEBUG_LOGGING", "fmi2SetDebugLogging fails"),
        ("read", "READ_FAILS", "a parameter cannot be read"),
        ("string", "STRING_NULL", "a string is a null pointer"),
        ("string", "STRING_LATIN1", "a string is not UTF-8"),
        ("write", "WRITE_FAILS", "an input cannot be set between steps"),
        ("write-ignored", "WRITE_IGNORED", "a parameter that is set keeps its value"),
        ("start-value", "START_VALUE", "a start value other than in the XML file"),
        ("data-changes", "FIXED_DRIFTS", "a fixed variable changes"),
        ("time", "TIME_LAGS", "the time is one step late"),
        ("finite", "NOT_FINITE", "an output is NaN"),
        ("range", "ENUMERATION", "an enumeration has a value that is no item"),
        ("range", "BOOLEAN", "a Boolean is 2"),
        ("deterministic", "RANDOM", "an output depends on the clock"),
        ("reset-replay", "RESET_FORGETS", "fmi2Reset leaves a state as it is"),
        ("varying-steps", "FIXED_STEP", "only one step size works"),
        ("state-replay", "STATE_FORGETS", "a hidden state is not saved"),
        ("state-free", "STATE_DANGLES", "fmi2FreeFMUstate leaves the pointer"),
        ("state-values", "STATE_INPUTS", "inputs and parameters are not saved"),
        ("serialize-replay", "SERIALIZE_FORGETS", "a hidden state is not serialized"),
        ("serialize-replay", "SERIALIZE_ROUNDS", "serialization rounds a state"),
        ("directional", "DIRECTIONAL", "directional derivatives fail though claimed"),
        ("input-derivatives", "INPUT_DERIVATIVES", "derivatives of inputs fail though claimed"),
        ("output-derivatives", "OUTPUT_DERIVATIVES", "derivatives of outputs fail though claimed"),
        ("log-off", "LOG_OFF", "messages though logging is off"),
        ("log-environment", "LOG_ENVIRONMENT", "the logger gets another environment"),
        ("log-name", "LOG_NAME", "the logger gets another name than the instance's"),
        ("discard-status", "DISCARD_STATUS", "the time of a discarded step is not told"),
        ("log-category", "LOG_CATEGORY", "messages of a category that is not listed"),
        ("memory", "LEAK", "20 kB stay behind with each instance"),
        ("memory", "SMALL_LEAK", "32 bytes stay behind with each instance"),
        ("memory", "KEEPS_INSTANCE", "fmi2FreeInstance does not free the instance"),
        ("memory", "STEP_LEAK", "1 kB stays behind with each step"),
        ("handles", "HANDLE_LEAK", "an open file stays behind with each instance"),
        ("guid", "ANY_GUID", "any GUID is taken"),
        ("call-order", "ORDER", "calls in the wrong mode are done"),
        ("zero-step", "ZERO_STEP", "a step of zero is done"),
        ("bad-step", "BAD_STEP", "a negative step is done"),
        ("bad-time", "BAD_TIME", "a step from a time of NaN is done"),
        ("fatal", "FATAL_REFUSAL", "a negative step is fatal"),
        ("log-refusal", "SILENT_REFUSAL", "a negative step is refused without a message"),
        ("unknown-reference", "UNKNOWN_REFERENCE", "unknown value references are ignored"),
        ("forbidden-write", "FORBIDDEN_WRITE", "everything can be set at any time"),
        ("nonfinite-input", "NAN_SILENT", "NaN goes in and out silently"),
        ("nonfinite-reset", "NAN_STICKS", "a NaN leaves a trace beyond fmi2Reset"),
        ("stop-time", "PAST_STOP", "a step beyond the stop time is done"),
        ("stop-time", "STOP_DISCARDS", "a step beyond the stop time is discarded"),
        ("stop-early", "STOP_EARLY", "the step to the stop time is refused"),
    )
)
