"""What the parent tells the child about the FMU under test, as plain data that is sent as JSON."""
import json
from dataclasses import asdict, dataclass, field


@dataclass(frozen=True)
class Known:
    """A variable as the probes need it; `start`, `low`, `high` are numbers (or text, for a String's start)."""
    name: str
    reference: int
    base: str  # Real, Integer, Boolean, String: which fmi2Get function reads it
    causality: str
    variability: str
    initial: str | None
    start: float | int | str | None
    low: float | None
    high: float | None
    nominal: float | None
    counts: bool  # an output or a state: the tolerance is of these
    items: list[int] = field(default_factory=list)  # the values of an enumeration


@dataclass(frozen=True)
class Job:
    """One FMU and which probes to run on it."""
    library: str
    guid: str
    resources: str  # a URI, section 2.1.5
    start: float
    stop: float | None
    step: float
    has_step: bool  # whether the file names it
    tolerance: float  # of a trajectory by its own scale: what the FMU's solver may differ
    has_tolerance: bool  # whether the file names it; then tolerance times nominal is allowed too, as solvers do (2.2.3)
    claims: dict[str, int]  # capability flags of 4.3.1 that are not false
    categories: list[str]  # names of the log categories
    variables: list[Known]
    probes: list[str]
    steps: int  # of a run
    cycles: int  # how often the memory probe instantiates and frees
    patience: float  # seconds that a probe may use on repetitions
    until: float  # by the system's monotonic clock: after this time no probe begins

    def to_json(self) -> str:
        """The job as text, for `read`."""
        return json.dumps(asdict(self))

    @staticmethod
    def read(text: str) -> "Job":
        """The job that `to_json` made a text of."""
        data = json.loads(text)
        data["variables"] = [Known(**variable) for variable in data["variables"]]
        return Job(**data)
