"""The XML file and its header. FMI 2.0: sections 2.2, 2.2.1, 2.2.4 to 2.2.6 and 4.3.1; 3.0: 2.4 to 2.4.2 and 4.4."""
import re
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta

from ...master.declared import number
from ..repeats import repeated
from ..rule import static
from ..subject import Fault, Fmu

STANDARD_CATEGORIES = ("logEvents", "logSingularLinearSystems", "logNonlinearSystems", "logDynamicStateSelection",
                       "logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal", "logStatusPending",
                       "logAll")
C_KEYWORDS = """auto break case char const continue default do double else enum extern float for goto if inline int
    long register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while"""
DATE = "%Y-%m-%dT%H:%M:%SZ"


@static("xml.encoding")
def encoding(fmu: Fmu) -> Iterator[Fault]:
    if fmu.encoding is not None and fmu.encoding.lower() != "utf-8":
        yield Fault("modelDescription.xml", f"encoding '{fmu.encoding}'", "encoding 'UTF-8'")


@static("xml.encoding-declared")
def encoding_declared(fmu: Fmu) -> Iterator[Fault]:
    if fmu.encoding is None:
        yield Fault("modelDescription.xml", "no encoding in the first line", '<?xml version="1.0" encoding="UTF-8"?>')


def not_finite(fmu: Fmu, names: set[str]) -> Iterator[Fault]:
    """A fault for each attribute in `names` that is NaN or infinite."""
    for element in fmu.description.root.iter("Real", "BaseUnit", "DisplayUnit", "DefaultExperiment"):
        for name in sorted(names & {str(key) for key in element.attrib}):
            text = str(element.get(name)).strip()
            if text.lstrip("+-").lower() in ("nan", "inf", "infinity"):
                owner = element.get("name") or getattr(element.getparent(), "attrib", {}).get("name", element.tag)
                yield Fault(str(owner), f"{name} '{text}'", "a finite number")


@static("xml.finite")
def finite(fmu: Fmu) -> Iterator[Fault]:
    yield from not_finite(fmu, {"start"})


@static("xml.finite-attribute")
def finite_attribute(fmu: Fmu) -> Iterator[Fault]:
    names = {"min", "max", "nominal", "factor", "offset", "startTime", "stopTime", "tolerance", "stepSize"}
    yield from not_finite(fmu, names)


def interfaces(fmu: Fmu) -> tuple[str, ...]:
    """The elements that an interface type has."""
    return "CoSimulation", "ModelExchange", *(("ScheduledExecution",) if fmu.description.flat else ())


@static("header.interface")
def interface(fmu: Fmu) -> Iterator[Fault]:
    if not any(fmu.description.attributes_at(tag) is not None for tag in interfaces(fmu)):
        yield Fault("fmiModelDescription", f"none of {', '.join(interfaces(fmu))}", "at least one of them")


@static("header.guid")
def guid(fmu: Fmu) -> Iterator[Fault]:
    if fmu.description.attributes.get(fmu.version.token, "?").strip() == "":
        yield Fault(fmu.version.token, "an empty string", "a fingerprint of the XML file")


@static("header.model-name")
def model_name(fmu: Fmu) -> Iterator[Fault]:
    if fmu.description.attributes.get("modelName", "?").strip() == "":
        yield Fault("modelName", "an empty string", "the name of the model")


@static("header.date")
def date(fmu: Fmu) -> Iterator[Fault]:
    text = fmu.description.attributes.get("generationDateAndTime")
    if text is not None and parsed_date(text) is None:
        yield Fault("generationDateAndTime", f"'{text}'", "YYYY-MM-DDThh:mm:ssZ, as in '2009-12-08T14:33:22Z'")


@static("header.date-past")
def date_past(fmu: Fmu) -> Iterator[Fault]:
    text = fmu.description.attributes.get("generationDateAndTime", "")
    when = parsed_date(text)
    if when is not None and when > datetime.now(UTC) + timedelta(days=1):
        yield Fault("generationDateAndTime", f"'{text}'", "a time in the past")


def parsed_date(text: str) -> datetime | None:
    """The date in the standard's form, or None."""
    try:
        return datetime.strptime(text.strip(), DATE).replace(tzinfo=UTC)
    except ValueError:
        return None


@static("header.event-indicators")
def event_indicators(fmu: Fmu) -> Iterator[Fault]:
    count = fmu.description.attributes.get("numberOfEventIndicators", "0").strip()
    if fmu.description.model_exchange is None and count not in ("0", ""):
        yield Fault("numberOfEventIndicators", count, "no such attribute in a pure co-simulation FMU")


@static("header.model-identifier")
def model_identifier(fmu: Fmu) -> Iterator[Fault]:
    for tag in interfaces(fmu):
        name = (fmu.description.attributes_at(tag) or {}).get("modelIdentifier")
        if name is not None and (not re.fullmatch(r"[A-Za-z_][A-Za-z_0-9]*", name) or name in C_KEYWORDS.split()):
            yield Fault("modelIdentifier", f"'{name}'", "letters, digits and '_', not beginning with a digit")
            return


@static("header.serialize-needs-state")
def serialize_needs_state(fmu: Fmu) -> Iterator[Fault]:
    if fmu.description.claims("canSerializeFMUstate") and not fmu.description.claims("canGetAndSetFMUstate"):
        yield Fault("canSerializeFMUstate", "true while canGetAndSetFMUstate is false", "both true, or both false")


@static("header.early-return")
def early_return(fmu: Fmu) -> Iterator[Fault]:
    flag, needed = "canReturnEarlyAfterIntermediateUpdate", "providesIntermediateUpdate"
    if fmu.description.claims(flag) and not fmu.description.claims(needed):
        yield Fault(flag, f"true while {needed} is false", "both true, or both false")


@static("header.interpolate-needs-input")
def interpolate_needs_input(fmu: Fmu) -> Iterator[Fault]:
    inputs = [v for v in fmu.description.variables if v.causality == "input" and v.variability == "continuous"]
    if fmu.description.claims("canInterpolateInputs") and not inputs:
        yield Fault("canInterpolateInputs", "true without a continuous input", "false, or a continuous input")


@static("log.unique")
def log_unique(fmu: Fmu) -> Iterator[Fault]:
    for name, count in repeated(categories(fmu)):
        yield Fault(name, f"{count} categories of this name", "one")


@static("log.standard-name")
def log_standard_name(fmu: Fmu) -> Iterator[Fault]:
    standard = {name.lower(): name for name in STANDARD_CATEGORIES}
    for name in categories(fmu):
        meant = standard.get(name.lower())
        if meant is not None and meant != name:
            yield Fault(name, f"'{name}'", f"'{meant}'")


def categories(fmu: Fmu) -> list[str]:
    """The names of the log categories."""
    return [category.get("name", "") for category in fmu.description.root.iterfind("LogCategories/Category")]


def experiment(fmu: Fmu, attribute: str) -> float | None:
    """A number of the default experiment, or None."""
    element = fmu.description.root.find("DefaultExperiment")
    return None if element is None else number(element.get(attribute))


@static("experiment.stop")
def experiment_stop(fmu: Fmu) -> Iterator[Fault]:
    start, stop = experiment(fmu, "startTime"), experiment(fmu, "stopTime")
    if start is not None and stop is not None and stop < start:
        yield Fault("stopTime", f"{stop:g} with startTime {start:g}", "stopTime >= startTime")


@static("experiment.tolerance")
def experiment_tolerance(fmu: Fmu) -> Iterator[Fault]:
    tolerance = experiment(fmu, "tolerance")
    if tolerance is not None and tolerance < 0:
        yield Fault("tolerance", f"{tolerance:g}", "a value above 0")


@static("experiment.step")
def experiment_step(fmu: Fmu) -> Iterator[Fault]:
    step = experiment(fmu, "stepSize")
    if step is not None and step <= 0:
        yield Fault("stepSize", f"{step:g}", "a value above 0")


@static("experiment.step-fits")
def experiment_step_fits(fmu: Fmu) -> Iterator[Fault]:
    start, stop, step = (experiment(fmu, name) for name in ("startTime", "stopTime", "stepSize"))
    length = None if stop is None else stop - (start or 0.0)
    if step is not None and length is not None and 0 < length < step:
        yield Fault("stepSize", f"{step:g} in an experiment of {length:g} s", "a step that fits in")


@static("annotation.unique")
def annotation_unique(fmu: Fmu) -> Iterator[Fault]:
    for listed in fmu.description.root.iter("VendorAnnotations", "Annotations"):
        for name, count in repeated(tool.get("name", "") for tool in listed.iterfind("Tool")):
            yield Fault(name, f"{count} annotations of this tool", "one")
