"""How every picture of the project looks, on the screen and in a paper: palette, line styles, sizes, file formats."""
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .errors import UsageError

if TYPE_CHECKING:  # matplotlib is slow to import: only who draws pays for it
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's palette, for colour-blind readers. Neighbours differ in lightness as well, and the line style tells
# all of them apart in grey.
BLUE, ORANGE, BLACK, RED, GREEN, PINK, SKY = (
    "#0072B2", "#E69F00", "#000000", "#D55E00", "#009E73", "#CC79A7", "#56B4E9")
COLOURS = (BLUE, ORANGE, BLACK, RED, GREEN, PINK, SKY)
LINES: tuple[Any, ...] = ("-", (0, (4, 1.6)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)), (0, (3, 1, 1, 1, 1, 1)),
                          (0, (9, 2)), (0, (2, 1)))
MARKS = ("o", "s", "^", "D", "v", "P", "X")
THICK, THIN = 1.9, 0.9  # points: where curves coincide, the first is seen on both sides of the last

KINDS = ("png", "pdf", "svg")
WIDTHS = {1: 3.5, 2: 7.16}  # inches, by columns of a journal's page
DOTS = 150  # an inch, in png
STYLE: dict[str, Any] = {
    "font.size": 8, "axes.titlesize": 8, "axes.labelsize": 8, "xtick.labelsize": 7, "ytick.labelsize": 7,
    "legend.fontsize": 7, "legend.title_fontsize": 7, "figure.titlesize": 8, "legend.frameon": False,
    "legend.handlelength": 2.6, "axes.grid": True, "axes.axisbelow": True, "grid.alpha": 0.3, "grid.linewidth": 0.5,
    "axes.linewidth": 0.6, "lines.linewidth": 1.2, "lines.markersize": 3.5, "axes.formatter.useoffset": False,
    "savefig.dpi": DOTS,
    "pdf.fonttype": 42,        # TrueType, which journals accept
    "svg.fonttype": "none",    # text stays text
    "svg.hashsalt": "cosim",   # the same picture gives the same file
}
TIGHT: dict[str, Any] = {"borderaxespad": 0.1, "borderpad": 0.1, "labelspacing": 0.15, "columnspacing": 1.0,
                         "handletextpad": 0.4}
LETTER = 0.056  # inches, mean width of a letter of 7 points
DIGIT = 0.062   # inches
LINE = 0.12     # inches, height of a line of a legend
LEFT = 0.68     # inches, for tick labels as long as -1.25e-29; longer ones take from the axes


@dataclass(frozen=True)
class Format:
    """What pictures are written as: the kind of file and the width in columns of a journal's page (3.5 or 7.16
    inches). Raises UsageError for others."""
    kind: str = "png"
    columns: int = 2

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UsageError(f"--figures {self.kind}: pictures are written as {', '.join(KINDS[:-1])} or {KINDS[-1]}.")
        if self.columns not in WIDTHS:
            raise UsageError(f"--columns {self.columns}: pictures are 1 or 2 columns wide.")


PNG = Format()


class Curve(NamedTuple):
    """Values over time (s), both of shape (rows,). `line` are matplotlib's words where the palette is not wanted."""
    label: str
    time: np.ndarray
    values: np.ndarray
    line: Mapping[str, Any] = {}


REFERENCE = {"color": "0.65", "linewidth": 3.2, "linestyle": "-"}   # seen on both sides of a curve that follows it
COMMAND = {"color": "0.25", "linewidth": 0.6, "linestyle": "-"}   # much thinner than all curves


@dataclass(frozen=True)
class Panel:
    """Curves over the same axes: what they show, with its unit."""
    label: str
    curves: Sequence[Curve]
    height: float = 1.2  # inches


def colour(number: int) -> str:
    """The palette's colour of curve `number`, from its begin again after the last."""
    return COLOURS[number % len(COLOURS)]


def styled(count: int) -> list[dict[str, Any]]:
    """Colour, line style and width of each of `count` curves that share axes; thinner from the first to the last."""
    widths = np.linspace(THICK, THIN, count) if count > 1 else [1.2]
    looks = zip(widths, cycle(COLOURS), cycle(LINES))
    return [{"color": hue, "linestyle": line, "linewidth": width} for width, hue, line in islice(looks, count)]


@contextmanager
def style() -> Iterator[None]:
    """What is drawn and saved inside has the project's style."""
    import matplotlib
    from cycler import cycler

    chosen: dict[Any, Any] = {**STYLE, "axes.prop_cycle": cycler(color=COLOURS) + cycler(linestyle=LINES)}
    with matplotlib.rc_context(chosen):
        yield


def save(figure: "Figure", path: Path, form: Format = PNG) -> Path:
    """Write `figure` beside `path`, whose suffix becomes that of the format; the file's path. Raises OSError."""
    path = path.with_suffix(f".{form.kind}")
    # Without a date, the same picture gives the same file.
    options: dict[str, Any] = {"png": {"pil_kwargs": {"compress_level": 1}},
                               "pdf": {"metadata": {"CreationDate": None}}, "svg": {"metadata": {"Date": None}}}
    with style():
        figure.savefig(path, dpi=DOTS, **options[form.kind])
    return path


def over_time(panels: Sequence[Panel], title: str, columns: int = 2, zoom: tuple[float, float] | None = None,
              kind: "type[Figure] | None" = None) -> "Figure":
    """Panels above each other over the same time (s), as a Figure or a `kind` of it.

    With `zoom`, an interval (s), each panel is drawn once more over that interval: beside it where there are two
    columns, else below. All margins are known beforehand, in inches: finding them from the texts takes as long as all
    the drawing.
    """
    from matplotlib.figure import Figure  # without pyplot, which is slow to import and keeps every figure

    width = WIDTHS[columns]
    spans = [None, zoom] if zoom else [None]
    across = len(spans) if columns == 2 else 1
    each = (width - LEFT * across - 0.12) / across
    heading = fill(title, int(width / LETTER * 0.9)) if title else ""
    shared = len(panels) > 1 and len({names_of(panel, plain=True) for panel in panels} | {()}) == 2
    gaps = [max(0.27, 0.16 + LINE * (0 if shared else legend_lines(panel, each))) for panel in panels]
    block = sum(gaps) + sum(panel.height for panel in panels) + 0.38
    fullest = max(panels, key=lambda panel: len(names_of(panel)))
    top = 0.06 + 0.15 * len(heading.splitlines())
    place = top
    if shared:
        top += LINE * -(-len(names_of(fullest)) // legend_columns(fullest, width - 0.2))
    height = top + block * (len(spans) // across)
    with style():
        figure = (kind or Figure)(figsize=(width, height))
        for number, span in enumerate(spans):
            left = LEFT - 0.02 + (number % across) * (each + LEFT)
            at, first = height - top - block * (number // across), None
            for gap, panel in zip(gaps, panels):
                at -= gap + panel.height
                box = (left / width, at / height, each / width, panel.height / height)
                axis = figure.add_axes(box, sharex=first)
                first = first or axis
                fill_axes(axis, panel, span)
                if number == 0 and not shared and names_of(panel):
                    axis.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=legend_columns(panel, each), **TIGHT)
                if number == 0 and shared and panel is fullest:
                    figure.legend(*axis.get_legend_handles_labels(), loc="upper center", **TIGHT,
                                  bbox_to_anchor=(0.5, 1 - place / height), ncols=legend_columns(panel, width - 0.2))
                axis.tick_params(bottom=panel is panels[-1], labelbottom=panel is panels[-1])
            axis.set_xlabel("time (s)", labelpad=1)
        figure.text(0.5, 1 - 0.05 / height, heading, ha="center", va="top")
        lacking = (max(map(longest_tick, figure.axes)) * DIGIT + 0.17 - LEFT) / width
        for axis in figure.axes if lacking > 0 else ():
            left, low, across, high = axis.get_position().bounds
            axis.set_position((left + lacking, low, across - lacking, high))
    return figure


def longest_tick(axis: "Axes") -> int:
    """Letters of the longest label of a tick on the y axis."""
    low, high = sorted(axis.get_ylim())
    return max((len(number(place)) for place in axis.get_yticks() if low <= place <= high), default=0)


def fill_axes(axis: "Axes", panel: Panel, span: tuple[float, float] | None) -> None:
    """Draw the panel; over `span` only, if there is one, with limits of its own."""
    plain = [curve for curve in panel.curves if not curve.line]
    looks = iter(styled(len(plain)))
    shown = []
    for curve in panel.curves:
        axis.plot(curve.time, curve.values, label=curve.label, **(curve.line or next(looks)))
        if span and not curve.line:
            shown.append(curve.values[(curve.time >= span[0]) & (curve.time <= span[1])])
    begin, end = span or (min(c.time[0] for c in panel.curves), max(c.time[-1] for c in panel.curves))
    axis.set_xlim(begin, max(end, begin + 1e-9))
    if shown:
        values = np.concatenate(shown)
        values = values[np.isfinite(values)]
        if len(values) and values.min() < values.max():
            margin = 0.06 * (values.max() - values.min())
            axis.set_ylim(values.min() - margin, values.max() + margin)
    axis.yaxis.set_major_formatter(number)
    # Above the axes, where no tick label can meet it, however long that is.
    axis.set_ylabel(panel.label if span is None else f"{panel.label}, {span[0]:g} to {span[1]:g} s", rotation=0,
                    ha="left", va="bottom")
    axis.yaxis.set_label_coords(0, 1.02)


def names_of(panel: Panel, plain: bool = False) -> tuple[str, ...]:
    """The names of its curves; without those that have a line of their own, if `plain`."""
    return tuple(curve.label for curve in panel.curves if curve.label and not (plain and curve.line))


def legend_columns(panel: Panel, width: float) -> int:
    """How many names of curves a line of `width` inches has room for."""
    names = names_of(panel)
    longest = max((len(name.replace(r"\$", "$")) for name in names), default=0)
    return max(1, min(len(names), int(width / (0.40 + LETTER * longest))))


def legend_lines(panel: Panel, width: float) -> int:
    """Lines of text above a panel of `width` inches: its label, and the names of its curves beside or above that."""
    names = names_of(panel)
    if not names:
        return 0
    columns = legend_columns(panel, width)
    lines = -(-len(names) // columns)
    longest = max(map(len, names))
    beside = lines == 1 and LETTER * len(panel.label) + columns * (0.40 + LETTER * longest) < width
    return 0 if beside else lines


def number(value: float, _: object = None) -> str:
    """A tick's label: never a factor or an offset that stands elsewhere."""
    return f"{value:.10g}".replace("-", "\N{MINUS SIGN}")


def merged(curves: Sequence[Curve]) -> list[Curve]:
    """Curves that are equal as one curve, with all their names."""
    found: list[Curve] = []
    for curve in curves:
        for i, other in enumerate(found):
            if other.line == curve.line and np.array_equal(other.values, curve.values):
                found[i] = other._replace(label=f"{other.label}, {curve.label}")
                break
        else:
            found.append(curve)
    return found


def where_they_differ(panels: Sequence[Panel], share: float = 0.05) -> tuple[float, float] | None:
    """The interval (s), `share` of all time long, in which the curves of the panels differ most, each by the range of
    its panel; None where no panel has two curves that differ."""
    many = [[c for c in panel.curves if not c.line] for panel in panels]
    many = [curves for curves in many if len(curves) > 1]
    if not many:
        return None
    begin = max(c.time[0] for curves in many for c in curves)
    end = min(c.time[-1] for curves in many for c in curves)
    grid = np.linspace(begin, end, 2001)
    total = np.zeros(len(grid))
    for curves in many:
        values = np.array([np.interp(grid, c.time, c.values) for c in curves])
        size = np.ptp(values)
        total += np.nan_to_num(np.ptp(values, axis=0) / size) if size > 0 else 0.0
    if not total.any():
        return None
    rows = int(share * (len(grid) - 1))
    sums = np.convolve(total, np.ones(rows), "valid")[::rows // 10]  # begins at a round time, where the ends are round
    first = int(sums.argmax()) * (rows // 10)
    return float(grid[first]), float(grid[first + rows])
