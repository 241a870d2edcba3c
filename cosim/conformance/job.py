"""What the parent tells the child about the FMU under test, as plain data that is sent as JSON."""
import json
from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class Known:
    """A variable as the probes need it; `start`, `low`, `high` are numbers (or text, for a String's start)."""
    name: str
    reference: int
    base: str  # Real, Integer, Boolean, String; Float64, Int8, ... in FMI 3.0: which Get function reads it
    causality: str
    variability: str
    initial: str | None
    start: float | int | str | None
    low: float | None
    high: float | None
    nominal: float | None
    counts: bool  # an output or a state: the tolerance is of these
    items: list[int] = field(default_factory=list)  # the values of an enumeration
    count: int | None = None  # of an array's elements, whose start values are in `starts`
    starts: list[float | int | str | None] = field(default_factory=list)

    @property
    def is_real(self) -> bool:
        """Whether it is a Real, or a float of FMI 3.0."""
        return self.base in ("Real", "Float64", "Float32")

    @property
    def is_text(self) -> bool:
        """Whether its values are texts; binaries are hexadecimal ones."""
        return self.base in ("String", "Binary")

    def elements(self) -> "list[Known]":
        """The elements of an array; of another variable itself."""
        if self.count is None:
            return [self]
        return [replace(self, name=f"{self.name}[{i + 1}]", start=self.starts[i] if self.starts else None, count=None,
                        starts=[]) for i in range(self.count)]


@dataclass(frozen=True)
class Job:
    """One FMU and which probes to run on it."""
    library: str
    guid: str
    resources: str  # a URI, section 2.1.5; in FMI 3.0 a path
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
    version: str  # of FMI
    clocks: str  # triggered, or timed where one has an interval; empty without clocks
    fixed_step: float  # that a step is a multiple of; 0 if any step will do
    until: float  # by the system's monotonic clock: after this time no probe begins

    def to_json(self) -> str:
        """The job as text, for `read`."""
        return json.dumps(vars(self), default=vars)

    @staticmethod
    def read(text: str) -> "Job":
        """The job that `to_json` made a text of."""
        data = json.loads(text)
        data["variables"] = [Known(**variable) for variable in data["variables"]]
        return Job(**data)
