"""What a native FMU answers to the calls of model exchange, in each state, through either version of FMI.

A row is (call, argument, answers), the answers in the order of STATES.
"""

STATES = ("instantiated", "initialising", "at an event", "in continuous time", "terminated")

ROWS = [
    ("EnterInitializationMode", "", "OK error error error error"),
    ("ExitInitializationMode", "", "error OK error error error"),
    ("EnterEventMode", "", "error error error OK error"),
    ("NewDiscreteStates", "", "error error OK error error"),
    ("NewDiscreteStates", "without a place for the answer", "error error error error error"),
    ("EnterContinuousTimeMode", "", "error error OK error error"),
    ("CompletedIntegratorStep", "", "error error error OK error"),
    ("CompletedIntegratorStep", "past the stop time", "error error error error error"),
    ("CompletedIntegratorStep", "without a place for the answer", "error error error error error"),
    ("Terminate", "", "error error OK OK error"),
    ("Reset", "", "OK OK OK OK OK"),
    ("DoStep", "10 ms", "error error error error error"),

    ("SetTime", "1 s", "error error OK OK error"),
    ("SetTime", "nan", "error error error error error"),
    ("SetContinuousStates", "its own", "error error error OK error"),
    ("SetContinuousStates", "one too few", "error error error error error"),
    ("SetContinuousStates", "a null pointer", "error error error error error"),
    ("GetContinuousStates", "", "OK OK OK OK OK"),
    ("GetContinuousStates", "one too few", "error error error error error"),
    ("GetDerivatives", "", "OK OK OK OK OK"),
    ("GetDerivatives", "into a null pointer", "error error error error error"),
    ("GetNominalsOfContinuousStates", "", "OK OK OK OK OK"),
    ("GetNominalsOfContinuousStates", "one too many", "error error error error error"),
    ("GetEventIndicators", "none", "OK OK OK OK OK"),
    ("GetEventIndicators", "one", "error error error error error"),

    ("GetReal", "a derivative", "OK OK OK OK OK"),
    ("SetReal", "a derivative", "error error error error error"),
    ("SetReal", "elevator = 0.2", "OK OK OK OK error"),
    ("SetReal", "mass = 310", "OK OK error error error"),
    ("GetDirectionalDerivative", "of a derivative for an input", "OK OK OK OK OK"),
    ("GetDirectionalDerivative", "of a derivative for a state", "error error OK OK OK"),
    ("GetDirectionalDerivative", "of a derivative for a parameter", "OK OK error error error"),
    ("GetDirectionalDerivative", "of a derivative for a derivative", "error error error error error"),
]
