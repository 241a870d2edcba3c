"""What differs between FMI 2.0 and FMI 3.0 for the rules and the report: folders, functions, tables and words."""
import platform
import re
import sys
from dataclasses import dataclass

from ..master.declared import INITIAL

SYSTEMS = {"windows": ".dll", "linux": ".so", "darwin": ".dylib"}
MACHINES = {"x86": "x86", "x86_64": "x86_64", "aarch32": "arm", "aarch64": "aarch64", "riscv32": "riscv",
            "riscv64": "riscv", "ppc32": "0x14", "ppc64": "0x15"}  # platform tuple -> how `binary` calls it
PLATFORM = tuple[str, str, frozenset[str]]  # suffix, operating system, allowed processors


@dataclass(frozen=True)
class Version:
    """One version of FMI.

    `always` are the functions that every FMU for co-simulation exports, `by_flag` those that a capability needs, and
    `others` those that nobody calls for co-simulation. `platforms` has the folders below binaries/.
    """
    name: str
    prefix: str
    token: str  # the attribute that a binary compares
    platforms: dict[str, PLATFORM]
    entries: frozenset[str]  # of the archive's root
    always: str
    by_flag: dict[str, str]
    others: str
    initial: dict[tuple[str, str], tuple[str, ...]]  # (variability, causality) -> allowed `initial`, the default first
    flags: tuple[str, ...]  # capabilities of the co-simulation interface, as the probes call them

    @property
    def host(self) -> str:
        """The name of the folder below binaries/ that holds this machine's library."""
        system = {"Windows": "windows", "Darwin": "darwin"}.get(platform.system(), "linux")
        machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
        if self.name == "3.0":
            return f"{machine}-{system}"
        return f"{system.removesuffix('dows')}{'64' if sys.maxsize > 2**32 else '32'}"


FMI2 = Version(
    name="2.0",
    prefix="fmi2",
    token="guid",
    platforms={
        "win32": (".dll", "windows", frozenset({"x86"})),
        "win64": (".dll", "windows", frozenset({"x86_64"})),
        "linux32": (".so", "linux", frozenset({"x86"})),
        "linux64": (".so", "linux", frozenset({"x86_64"})),
        "darwin32": (".dylib", "darwin", frozenset({"x86"})),
        "darwin64": (".dylib", "darwin", frozenset({"x86_64", "aarch64"})),
    },
    entries=frozenset({"modelDescription.xml", "model.png", "binaries", "sources", "resources", "documentation",
                       "licenses", "extra", "terminalsAndIcons"}),
    always="""GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment
        EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal
        SetInteger SetBoolean SetString DoStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus
        GetStringStatus""",
    by_flag={
        "canGetAndSetFMUstate": "GetFMUstate SetFMUstate FreeFMUstate",
        "canSerializeFMUstate": "SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate",
        "providesDirectionalDerivative": "GetDirectionalDerivative",
        "canInterpolateInputs": "SetRealInputDerivatives",
        "maxOutputDerivativeOrder": "GetRealOutputDerivatives",
        "canRunAsynchronuously": "CancelStep",
    },
    others="",
    initial=INITIAL,
    flags=("canHandleVariableCommunicationStepSize", "canInterpolateInputs", "canRunAsynchronuously",
           "needsExecutionTool", "canBeInstantiatedOnlyOncePerProcess", "canGetAndSetFMUstate", "canSerializeFMUstate",
           "providesDirectionalDerivative"),
)

TYPES3 = ("Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean",
          "String", "Binary", "Clock")
FMI3 = Version(
    name="3.0",
    prefix="fmi3",
    token="instantiationToken",
    platforms={f"{machine}-{system}": (suffix, system, frozenset({made_for}))
               for machine, made_for in MACHINES.items() for system, suffix in SYSTEMS.items()},
    entries=frozenset({"modelDescription.xml", "binaries", "sources", "resources", "documentation", "extra",
                       "terminalsAndIcons"}),
    always=f"""GetVersion SetDebugLogging InstantiateCoSimulation FreeInstance EnterInitializationMode
        ExitInitializationMode Terminate Reset DoStep {' '.join(f'Get{base} Set{base}' for base in TYPES3)}""",
    by_flag={
        "canGetAndSetFMUState": "GetFMUState SetFMUState FreeFMUState",
        "canSerializeFMUState": "SerializedFMUStateSize SerializeFMUState DeserializeFMUState",
        "providesDirectionalDerivatives": "GetDirectionalDerivative",
        "providesAdjointDerivatives": "GetAdjointDerivative",
        "providesPerElementDependencies": "GetNumberOfVariableDependencies GetVariableDependencies",
        "maxOutputDerivativeOrder": "GetOutputDerivatives",
        "hasEventMode": "EnterEventMode UpdateDiscreteStates EnterStepMode",
        "providesEvaluateDiscreteStates": "EvaluateDiscreteStates",
    },
    others="""InstantiateModelExchange InstantiateScheduledExecution EnterConfigurationMode ExitConfigurationMode
        GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction SetIntervalDecimal SetIntervalFraction
        SetShiftDecimal SetShiftFraction EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates
        GetContinuousStateDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates
        GetNumberOfEventIndicators GetNumberOfContinuousStates ActivateModelPartition""",
    initial={**INITIAL, ("fixed", "structuralParameter"): ("exact",), ("tunable", "structuralParameter"): ("exact",),
             ("discrete", "input"): ("exact",), ("continuous", "input"): ("exact",)},
    flags=("canHandleVariableCommunicationStepSize", "needsExecutionTool", "canBeInstantiatedOnlyOncePerProcess",
           "canGetAndSetFMUstate", "canSerializeFMUstate", "providesDirectionalDerivative", "hasEventMode"),
)
VERSIONS = {version.name: version for version in (FMI2, FMI3)}

# How the words of FMI 2.0, in which rules and probes speak, are said in FMI 3.0; in this order.
WORDS3 = (
    (r"fmi2Instantiate\b", "fmi3InstantiateCoSimulation"), (r"fmi2SetupExperiment\b", "fmi3EnterInitializationMode"),
    (r"fmi2(Get|Set)Real\b", r"fmi3\1Float64"), (r"fmi2GetRealOutputDerivatives\b", "fmi3GetOutputDerivatives"),
    (r"fmi2DeSerialize", "fmi3Deserialize"), (r"FMUstate", "FMUState"),
    (r"providesDirectionalDerivative\b", "providesDirectionalDerivatives"),
    (r"\bfmi2(?=[A-Z])", "fmi3"), (r"\bfmi2Model", "fmi3Model"), (r"\bGUID\b", "instantiation token"),
    (r"componentEnvironment of fmi2CallbackFunctions", "instanceEnvironment"), (r"\bReals\b", "floats"),
    (r"\bReal\b", "float"),
)


def spoken(text: str, version: str) -> str:
    """A text in the words of a version."""
    if version == "3.0":
        for old, new in WORDS3:
            text = re.sub(old, new, text)
    return text
