"""Which models there are: one place. The FMU's name -> the module that holds the model (see `fmus.interface`)."""

MODELS = {
    "AhvPlant": "ahv_plant_fmu.model",
    "AhvInstrumentedPlant": "ahv_plant_fmu.instrumented_model",
    "AhvController": "ahv_ctrl_fmu.neural_model",
    "AhvBackstepping": "ahv_ctrl_fmu.backstepping_model",
    "AhvScenario": "cosim.vehicle.scenario_model",
}
