"""Which laws, plants and scenario models there are: the one place that names them.

The builder takes its models from here. So do the command line its words and help, `ahv compare` its rows, and the
tests their parameters. A law has the ports of `AhvController`, a plant those of `AhvPlant`.
"""
from dataclasses import dataclass


@dataclass(frozen=True)
class Model:
    """One of our models: the word that names it, its FMU, the module of its equations, and one line for people."""
    word: str
    fmu: str
    module: str
    summary: str
    preset: str | None = None         # what flies where nobody says which; None: the FMU's start values
    compared: tuple[str, ...] = ()    # the presets that `ahv compare` flies
    remark: str = ""                  # stands behind the law's name where laws are compared
    learns: bool = False              # what it keeps of its flight decides how it flies at rest
    gains: tuple[str, ...] = ()       # the parameters that `ahv tune` may change


def by_word(*models: Model) -> dict[str, Model]:
    """Models by the word that names them."""
    return {model.word: model for model in models}


LAWS = by_word(
    Model("neural", "AhvController", "ahv_ctrl_fmu.neural_model", "the paper's adaptive neural law", "calibrated",
          ("calibrated", "robust"),
          gains=("kV1", "kV2", "k_gamma", "kh", "kh1", "mu", "c_theta", "c_Q", "pitch_rate_gain", "R", "R_d",
                 "a2", "a3", "a4", "lambda_1", "lambda_2")),
    Model("resilient", "AhvResilient", "ahv_ctrl_fmu.resilient_model",
          "a law that keeps the vehicle when its coefficients err on their own", "quiet", ("quiet",), learns=True,
          gains=("k_gamma", "k_path", "k_alpha", "k_Q", "k_V", "observer_V", "observer_gamma", "observer_Q",
                 "filter_h", "filter_gamma", "filter_lift", "filter_moment", "lift_lead", "moment_gain",
                 "moment_floor", "moment_washout", "hold_rate", "alpha_margin", "k_barrier", "barrier_margin",
                 "V_recovery", "elevator_band")),
    Model("backstepping", "AhvBackstepping", "ahv_ctrl_fmu.backstepping_model",
          "the law that the paper compares with, reconstructed", "calibrated", ("calibrated",), "a reconstruction",
          gains=("kV1", "kV2", "observer_V", "k_gamma", "k_path", "k_theta", "k_Q", "observer_gamma", "observer_Q",
                 "R_gamma", "R_theta", "R_Q")),
)
PLANTS = by_word(
    Model("ideal", "AhvPlant", "ahv_plant_fmu.model", "the vehicle with perfect actuators and sensors"),
    Model("instrumented", "AhvInstrumentedPlant", "ahv_plant_fmu.instrumented_model",
          "the vehicle with actuator lag and limits, sensor delay and noise"),
)
SCENARIO = Model("scenario", "AhvScenario", "cosim.vehicle.scenario_model", "commands and coefficient scales over time",
                 "hold")

# FMU -> the module of its equations.
MODELS = {model.fmu: model.module for model in (*PLANTS.values(), *LAWS.values(), SCENARIO)}


def choices(models: dict[str, Model]) -> str:
    """What a help text says of an option that takes one of `models`."""
    return "; ".join(f"{word}: {model.summary}" for word, model in models.items())
