"""The campaign file's dispersions, checked against the FMUs, as a list of draws."""
import math
from collections.abc import Mapping
from pathlib import Path

from ..errors import UsageError
from ..master.fmu import FmuFile
from ..master.system import System, Value
from ..yaml_file import Source
from .distributions import Distribution, Empirical, Given, Uniform
from .samples import Column, Samples, header, load, measured, sha256_of
from .sampling import EDGE, Draw, Mixing, free, mixing
from .spec import Campaign, Dispersion, Sinusoid

Fmus = Mapping[str, FmuFile]  # component -> its file
MOST_RUNS = 100_000_000
SINE = {"amplitude": "_sine", "period": "_sine_omega", "phase": "_sine_phase"}


def checked(files: Fmus, name: str, value: Value) -> Value:
    """`value` in the type of the variable component.variable. Raises UsageError if it may not be set to that."""
    component, _, variable = name.partition(".")
    if component not in files:
        raise UsageError(f"There is no component {component}; there are {', '.join(files)}.")
    return files[component].checked(variable, value, component)


def on_signal(files: Fmus, name: str, suffix: str = "_base") -> str | None:
    """The parameter that belongs to an output, such as scenario.scale_lift; None if `name` has none."""
    component, _, variable = name.partition(".")
    known = files[component].variables if component in files else {}
    is_signal = variable in known and known[variable].causality == "output" and variable + suffix in known
    return name + suffix if is_signal else None


def all_draws(source: Source, campaign: Campaign, system: System, files: Fmus, driven: Mapping[str, str],
              samples: Samples | None = None) -> tuple[Draw, ...]:
    """Every uncertain number: the columns of the samples, then the dispersions in the order of the file. `driven` are
    the inputs that are connected, each with its output.

    Raises UsageError for a variable that cannot be set, is set twice, or may not have such values.
    """
    found = [] if samples is None else given_draws(source, samples, files)
    taken = {}
    for one in found:
        if one.name in taken:
            source.fail(("samples",), f"{one.name} is set by two columns")
        taken[one.name] = "the samples"
    for name, dispersion in campaign.dispersions.items():
        with source.at("dispersions", name):
            check_sampling(campaign, dispersion)
            for one in draws_of(name, dispersion, system, files):
                values = ends(one)
                for target in one.targets:
                    check_kind(files, target, one)
                    if target in driven:
                        raise UsageError(f"{target} cannot be dispersed: {driven[target]} drives it.")
                    if target in taken:
                        raise UsageError(f"{target} is set by {taken[target]} already.")
                    taken[target] = name
                    for value in values:
                        checked(files, target, value)
                found.append(one)
    if not found:
        source.fail(("dispersions",), "nothing in it is drawn")
    return tuple(found)


def check_sampling(campaign: Campaign, dispersion: Dispersion) -> None:
    """Raises UsageError where a dispersion does not fit the way of sampling."""
    if campaign.sampling != "grid":
        if isinstance(dispersion, Uniform) and dispersion.points is not None:
            raise UsageError("points is for sampling: grid.")
    elif isinstance(dispersion, Sinusoid):
        raise UsageError("a grid takes values, or low, high and points.")
    else:
        dispersion.levels()


def check_kind(files: Fmus, target: str, one: Draw) -> None:
    """Raises UsageError where the draws are numbers of another kind than the variable's."""
    component, _, variable = target.partition(".")
    kind = files[component].variable(variable).type if component in files else "Real"
    if kind != "Real" and not one.distribution.single:
        raise UsageError(f"{target} ({kind}) takes the distribution choice or integer, not "
                         f"{one.distribution.distribution}.")


def draws_of(name: str, dispersion: Dispersion, system: System, files: Fmus) -> list[Draw]:
    """The draws of one dispersion, up to three of a sinusoid. Raises UsageError for a name that does not fit."""
    if isinstance(dispersion, Sinusoid):
        if on_signal(files, name, "_sine_omega") is None:
            signals = [f"{c}.{n}" for c in files for n in files[c].names("output")
                       if on_signal(files, f"{c}.{n}", "_sine_omega")]
            owners = " or ".join(f"the {c}" for c in dict.fromkeys(s.partition(".")[0] for s in signals))
            raise UsageError(f"{name} is no signal of {owners}; there are {', '.join(signals)}." if signals else
                             f"{name} cannot be a sinusoid: it is no output with parameters {name}_sine, "
                             f"{name}_sine_omega and {name}_sine_phase.")
        return [Draw(name + suffix, (name + suffix,), part, period=key == "period")
                for key, suffix in SINE.items() if not isinstance(part := getattr(dispersion, key), float)]
    targets = tuple(on_signal(files, n) or n for n in (name, *dispersion.also))
    factor = nominal(system, files, targets[0]) if dispersion.relative else None
    return [Draw(targets[0], targets, dispersion, factor)]


def nominal(system: System, files: Fmus, name: str) -> float:
    """The value of a number that nothing disperses."""
    component, _, variable = name.partition(".")
    for c in system.components:
        if c.name == component:
            value = c.values.get(variable, files[component].variable(variable).start)
            return float(checked(files, name, value if value is not None else 0.0))
    raise UsageError(f"There is no component {component}; there are {', '.join(files)}.")


def opened(source: Source, campaign: Campaign, files: Fmus) -> Samples | None:
    """The samples that a campaign names, of the kinds that the FMUs want.

    Raises UsageError for a file that is none, for a column that is no variable, and for a value of another kind.
    """
    if campaign.samples is None:
        return None
    with source.at("samples"):
        path = beside(source, campaign.samples)
        return load(path, campaign.samples, tuple(column_of(path, name, files) for name in header(path)))


def column_of(path: Path, name: str, files: Fmus) -> Column:
    """The column `name` of the samples in `path`. Raises UsageError for a name that is no variable."""
    target = on_signal(files, name) or name
    component, _, variable = target.partition(".")
    try:
        if not variable:
            raise UsageError("it is not of the form COMPONENT.VARIABLE.")
        if component not in files:
            raise UsageError(f"there is no component {component}; there are {', '.join(files)}.")
        family = files[component].variable(variable).family
    except UsageError as error:
        raise UsageError(f"{path}: column {name}: {error}") from None
    return Column(name, target, {"Boolean": "Boolean", "String": "String", "Real": "Real"}.get(family, "Integer"))


def given_draws(source: Source, samples: Samples, files: Fmus) -> list[Draw]:
    """The columns of the samples. Raises UsageError, with row and column, for a value that is not allowed."""
    found = []
    for column in samples.columns:
        for value, row in column.seen.items():
            with source.at("samples"):
                try:
                    checked(files, column.draw, value)
                except UsageError as error:
                    raise UsageError(f"{samples.file}: column {column.name}, row {row}: {error}") from None
        values = Given(file=samples.file, values=list(column.seen))
        found.append(Draw(column.draw, (column.draw,), values))
    return found


def with_measured(source: Source, campaign: Campaign) -> tuple[Campaign, dict[str, str]]:
    """The campaign with the numbers that its empirical distributions take from files; file -> SHA-256.

    Raises UsageError for a file or a column that cannot be used.
    """
    hashes: dict[str, str] = {}

    def filled(part: Distribution | float) -> Distribution | float:
        if not isinstance(part, Empirical) or part.file is None or part.column is None:
            return part
        path = beside(source, part.file)
        values = sorted(measured(path, part.column))
        hashes[part.file] = sha256_of(path)
        return part.model_copy(update={"values": values})

    changed = {}
    for name, one in campaign.dispersions.items():
        with source.at("dispersions", name):
            changed[name] = one.model_copy(update={key: filled(getattr(one, key)) for key in SINE}) \
                if isinstance(one, Sinusoid) else filled(one)
    return campaign.model_copy(update={"dispersions": changed}), hashes


def beside(source: Source, word: str) -> Path:
    """The file that the campaign file names."""
    return source.path.parent / Path(word).expanduser()


def run_count(source: Source, campaign: Campaign, samples: Samples | None, draws: tuple[Draw, ...]) -> int:
    """How many runs there are. Raises UsageError for more than a grid has points, or samples have rows."""
    if campaign.sampling == "grid":
        most, where = math.prod(len(d.levels) for d in draws), "the grid has only {} points"
    elif samples is not None:
        most, where = samples.rows, f"{samples.file} has only {{}} rows"
    else:
        return campaign.runs
    if campaign.runs > most:
        source.fail(("runs",), where.format(f"{most:,}"))
    if (campaign.runs or most) > MOST_RUNS:
        source.fail(("samples" if samples else "dispersions",), f"there are {most:,} runs; at most {MOST_RUNS:,} can "
                                                                f"be flown")
    return campaign.runs or most


def ends(one: Draw) -> list[Value]:
    """Values of the draw that must be allowed."""
    try:
        found = one.extremes()
        if one.period and not all(isinstance(x, float) and 0 < x < math.inf for x in found):
            raise UsageError("a period must be above 0.")
        drawn = [*found, one.value(EDGE), one.value(1 - EDGE)]
    except (ZeroDivisionError, ValueError):
        raise UsageError("a period must be above 0.") from None
    except OverflowError:
        drawn = [math.inf]
    if any(isinstance(x, float) and not math.isfinite(x) for x in drawn):
        raise UsageError("its draws would not be finite numbers: they lie too far apart.")
    return found


def constants(source: Source, campaign: Campaign, files: Fmus) -> dict[str, Value]:
    """Those numbers of sinusoids that are not drawn."""
    fixed: dict[str, Value] = {}
    for name, dispersion in campaign.dispersions.items():
        for key, suffix in SINE.items() if isinstance(dispersion, Sinusoid) else ():
            number = getattr(dispersion, key)
            if isinstance(number, float):
                with source.at("dispersions", name, key):
                    value = 2 * math.pi / number if key == "period" else number
                    fixed[name + suffix] = checked(files, name + suffix, value)
    return fixed


def all_mixings(source: Source, campaign: Campaign, draws: tuple[Draw, ...]) -> tuple[Mixing, ...]:
    """The correlated groups. Raises UsageError for groups that overlap, names that are not drawn and bad matrices."""
    draws = free(draws)
    names = [d.name for d in draws]
    found: list[Mixing] = []
    for i, group in enumerate(campaign.correlations):
        with source.at("correlations", i):
            one = mixing(group, names)
            both = {names[m] for m in one.members} & {names[m] for other in found for m in other.members}
            if both:
                raise UsageError(f"{min(both)} is in two correlated groups.")
            words = [names[m] for m in one.members if not draws[m].distribution.ordered]
            if words:
                raise UsageError(f"{words[0]} is a choice and has no order to correlate by.")
        found.append(one)
    return tuple(found)
