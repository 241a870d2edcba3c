"""What an FMU of this project answers to each call, in each state, in both flavours and both versions of FMI.

A row is (call, argument, answers of the native flavour, answers of the Python flavour, why they differ). Answers stand
in the order of STATES: OK, discard, error, fatal; a dash is a call that must not be made. `test_contract.py` makes the
calls.
"""

STATES = ("instantiated", "initialising", "stepping", "terminated")

# Why the Python flavour answers otherwise: all are properties of pythonfmu's binary, which it carries unchanged.
FATAL = "a refusal is an exception, and for an exception the binary returns fmi2Fatal"
NULLS = "the binary reads through null pointers"
GUID = "the binary looks at neither GUID nor type"
BUFFER = "the binary does not compare the size given with that of the state"
LATE = "an exception in this call would leave dangling references; fmi2SetFMUstate refuses the state"
MISSING = "the binary does not have it, and the model description does not claim it"
CATEGORY = "the binary takes any category"

ROWS = [
    ("Instantiate", "for co-simulation", "OK", "OK", None),
    ("Instantiate", "another GUID", "null", "OK", GUID),
    ("Instantiate", "for model exchange", "OK", "OK", None),
    ("Instantiate", "without a name", "null", "OK", GUID),

    ("SetupExperiment", "with start and stop", "OK error error error", "OK fatal fatal fatal", FATAL),
    ("SetupExperiment", "from nan", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetupExperiment", "from inf", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetupExperiment", "to before the start", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetupExperiment", "to nan", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("EnterInitializationMode", "", "OK error error error", "OK fatal fatal fatal", FATAL),
    ("ExitInitializationMode", "", "error OK error error", "fatal OK fatal fatal", FATAL),
    ("ExitInitializationMode", "after elevator = nan", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("ExitInitializationMode", "without lift", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("Terminate", "", "error error OK error", "fatal fatal OK fatal", FATAL),
    ("Reset", "", "OK OK OK OK", "OK OK OK OK", None),

    ("DoStep", "10 ms", "error error OK error", "fatal fatal OK fatal", FATAL),
    ("DoStep", "0 s", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "-10 ms", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "nan s", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "inf s", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "from nan", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "from -inf", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "of too many internal steps", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "up to the stop time", "error error OK error", "fatal fatal OK fatal", FATAL),
    ("DoStep", "past the stop time", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "after elevator = nan", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("DoStep", "out of the model's range", "error error discard error", "fatal fatal fatal fatal", FATAL),
    ("CancelStep", "", "error error error error", "error error error error", None),

    ("GetReal", "an output", "OK OK OK OK", "OK OK OK OK", None),
    ("GetReal", "a calculated parameter", "OK OK OK OK", "OK OK OK OK", None),
    ("GetReal", "an input and a parameter", "OK OK OK OK", "OK OK OK OK", None),
    ("GetReal", "nothing", "OK OK OK OK", "OK OK OK OK", None),
    ("GetReal", "nothing, without arrays", "OK OK OK OK", "OK OK OK OK", None),
    ("GetReal", "no variable", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("GetReal", "a Boolean", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("GetReal", "into a null pointer", "error error error error", "- - - -", NULLS),
    ("GetBoolean", "a parameter", "OK OK OK OK", "OK OK OK OK", None),
    ("GetBoolean", "a Real", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("GetInteger", "nothing", "OK OK OK OK", "OK OK OK OK", None),
    ("GetInteger", "a Real", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("GetInteger", "a null pointer", "error error error error", "- - - -", NULLS),
    ("GetString", "a Real", "error error error error", "fatal fatal fatal fatal", FATAL),

    ("SetReal", "elevator = 0.2", "OK OK OK error", "OK OK OK fatal", FATAL),
    ("SetReal", "elevator = nan", "discard discard discard error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "elevator = inf", "discard discard discard error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "mass = 310", "OK OK error error", "OK OK fatal fatal", FATAL),
    ("SetReal", "mass = -1", "discard discard error error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "mass = nan", "discard discard error error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "elevator = 0.2, mass = -1", "discard discard error error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "elevator = 0.2, V = 8000", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "V = 8000", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "theta_trim = 0.1", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "nothing", "OK OK OK OK", "OK OK OK OK", None),
    ("SetReal", "no variable", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "a Boolean", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetReal", "from a null pointer", "error error error error", "- - - -", NULLS),
    ("SetBoolean", "start_at_trim = false", "OK OK error error", "OK OK fatal fatal", FATAL),
    ("SetBoolean", "a Real", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetInteger", "a Real", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetString", "a Real", "error error error error", "fatal fatal fatal fatal", FATAL),

    ("GetFMUstate", "", "OK OK OK OK", "OK OK OK OK", None),
    ("SetFMUstate", "its own", "OK OK OK OK", "OK OK OK OK", None),
    ("SetFMUstate", "none", "error error error error", "- - - -", NULLS),
    ("FreeFMUstate", "its own", "OK OK OK OK", "OK OK OK OK", None),
    ("FreeFMUstate", "none", "OK OK OK OK", "OK OK OK OK", None),
    ("SerializeFMUstate", "its own", "OK OK OK OK", "OK OK OK OK", None),
    ("SerializeFMUstate", "into too few bytes", "error error error error", "OK OK OK OK", BUFFER),
    ("DeSerializeFMUstate", "its own", "OK OK OK OK", "OK OK OK OK", None),
    ("DeSerializeFMUstate", "changed bytes", "error error error error", "OK OK OK OK", LATE),
    ("SetFMUstate", "changed bytes", "error error error error", "fatal fatal fatal fatal", FATAL),
    ("SetFMUstate", "of another FMU", "error error error error", "fatal fatal fatal fatal", FATAL),

    ("GetDirectionalDerivative", "of an output for an input", "OK OK OK OK", "error error error error", MISSING),
    ("GetDirectionalDerivative", "of an output for a parameter", "OK OK error error", "error error error error",
     MISSING),
    ("GetDirectionalDerivative", "of an input", "error error error error", "error error error error", None),
    ("GetDirectionalDerivative", "of a parameter", "error error error error", "error error error error", None),
    ("SetRealInputDerivatives", "of an input", "error error error error", "error error error error", None),
    ("GetRealOutputDerivatives", "of an output", "error error error error", "error error error error", None),

    ("GetStatus", "of the last step", "OK OK OK OK", "error error error error", MISSING),
    ("GetStatus", "of a pending step", "discard discard discard discard", "error error error error", MISSING),
    ("GetStatus", "of another kind", "discard discard discard discard", "error error error error", MISSING),
    ("GetRealStatus", "last successful time", "OK OK OK OK", "OK OK OK OK", None),
    ("GetRealStatus", "of another kind", "discard discard discard discard", "discard discard discard discard", None),
    ("GetBooleanStatus", "terminated", "OK OK OK OK", "OK OK OK OK", None),
    ("GetBooleanStatus", "of another kind", "discard discard discard discard", "discard discard discard discard", None),
    ("GetIntegerStatus", "of any kind", "discard discard discard discard", "discard discard discard discard", None),
    ("GetStringStatus", "of any kind", "discard discard discard discard", "discard discard discard discard", None),
    ("SetDebugLogging", "a listed category", "OK OK OK OK", "OK OK OK OK", None),
    ("SetDebugLogging", "no category of ours", "error error error error", "OK OK OK OK", CATEGORY),
]
