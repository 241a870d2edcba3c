"""One style for all pictures: formats and sizes, nothing on top of anything else, and curves that grey tells apart."""
import re
from itertools import combinations, pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from PIL import Image

from cosim import pictures
from cosim.errors import UsageError
from cosim.pictures import COMMAND, REFERENCE, WIDTHS, Curve, Format, Panel

TIME = np.linspace(0.0, 100.0, 201)


def curve(label="", size=1.0, **line):
    return Curve(label, TIME, size * np.sin(0.1 * TIME), line)


def panels(laws=4):
    """As in a comparison whose flight departs: names in all panels, long tick labels."""
    names = ["neural", "neural, robust", "resilient", "backstepping (a reconstruction)"][:laws]
    return [Panel("h (ft)", [curve("reference", 9e4, **REFERENCE), *(curve(n, 9e4 + i) for i, n in enumerate(names)),
                             curve("command", 8e4, **COMMAND)]),
            Panel("$\\hat\\varphi_1$, velocity (1/s)", [curve(name, -1.25e-29) for name in names]),
            Panel("V (ft/s)", [Curve(name, TIME, 7700.0001 + 1e-5 * np.sin(0.1 * TIME)) for name in names])]


def lightness(colour):
    """0 black to 1 white, as a grey print shows it."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return (0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]) ** (1 / 2.2)


@pytest.mark.parametrize("columns", [1, 2])
@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_a_figure_has_the_width_of_its_columns_in_each_format(kind, columns, tmp_path):
    figure = pictures.over_time(panels(), "title", columns)
    path = pictures.save(figure, tmp_path / "figure_02.x", Format(kind, columns))
    assert path.name == f"figure_02.{kind}"
    if kind == "png":
        width = Image.open(path).width / pictures.DOTS
    elif kind == "pdf":
        box = re.search(rb"/MediaBox \[ ?([\d. ]+)\]", path.read_bytes())
        assert box and b"/Type3" not in path.read_bytes()
        width = float(box[1].split()[2]) / 72
    else:
        text = path.read_text()
        assert ">h (ft)</text>" in text
        width = float(re.search(r'width="([\d.]+)pt"', text)[1]) / 72
    assert width == pytest.approx(WIDTHS[columns], abs=0.01)


@pytest.mark.parametrize("kind", ["pdf", "svg"])
def test_the_same_picture_gives_the_same_file(kind, tmp_path):
    one, other = (pictures.save(pictures.over_time(panels(1), "", 1), tmp_path / name, Format(kind)).read_bytes()
                  for name in ("one", "other"))
    assert one == other


@pytest.mark.parametrize("zoom", [None, (10.0, 20.0)])
@pytest.mark.parametrize("columns", [1, 2])
@pytest.mark.parametrize("laws", [1, 4])
def test_no_text_stands_on_another_or_outside(laws, columns, zoom):
    title = "case1, neural (printed): Adapted parameters of the networks (ended at 19.68 s)"
    figure = pictures.over_time(panels(laws), title, columns, zoom)
    FigureCanvasAgg(figure).draw()
    texts = list(figure.texts)
    for axis in figure.axes:
        texts += [axis.yaxis.label, axis.xaxis.label, *shown(axis.yaxis)]
        texts += shown(axis.xaxis) if axis.xaxis.get_tick_params()["labelbottom"] else []
    texts += [text for legend in (*figure.legends, *(axis.get_legend() for axis in figure.axes)) if legend
              for text in legend.get_texts()]
    boxes = {f"{text.get_text()}, {i}": text.get_window_extent() for i, text in enumerate(texts) if text.get_text()}
    assert len(boxes) > 15
    assert [pair for pair in combinations(boxes, 2) if overlap(boxes[pair[0]], boxes[pair[1]])] == []
    whole = figure.bbox
    assert [name for name, box in boxes.items() if box.x0 < whole.x0 or box.x1 > whole.x1 or box.y0 < whole.y0
            or box.y1 > whole.y1] == []


def shown(axis):
    """The labels of the ticks within the limits: matplotlib keeps others, too."""
    low, high = sorted(axis.get_view_interval())
    return [text for place, text in zip(axis.get_ticklocs(), axis.get_ticklabels()) if low <= place <= high]


def overlap(one, other):
    return min(one.x1, other.x1) - max(one.x0, other.x0) > 1 and min(one.y1, other.y1) - max(one.y0, other.y0) > 1


def test_neighbouring_curves_differ_in_lightness_and_all_in_their_lines():
    looks = pictures.styled(len(pictures.COLOURS))
    assert len({str(look["linestyle"]) for look in looks}) == len(looks) == len(pictures.MARKS)
    for one, other in pairwise(looks[:4]):
        assert abs(lightness(one["color"]) - lightness(other["color"])) > 0.15
    assert np.all(np.diff([look["linewidth"] for look in looks]) < 0)
    assert lightness(REFERENCE["color"]) - lightness(looks[0]["color"]) > 0.15


def test_a_reference_is_seen_on_both_sides_of_the_curve_that_covers_it():
    axis = pictures.over_time([Panel("h (ft)", [curve("reference", **REFERENCE), curve("h")])], "").axes[0]
    below, above = axis.lines
    assert below.get_linewidth() > 2 * above.get_linewidth()


def test_equal_curves_are_one_with_both_names():
    found = pictures.merged([curve("lift"), curve("drag"), curve("moment", 2.0)])
    assert [one.label for one in found] == ["lift, drag", "moment"]


def test_the_enlargement_is_where_the_curves_differ_most():
    bump = np.exp(-(TIME - 63.0) ** 2)
    curves = [Curve("a", TIME, TIME), Curve("b", TIME, TIME + bump)]
    begin, end = pictures.where_they_differ([Panel("", curves)])
    assert end - begin == pytest.approx(5.0) and begin < 61.0 and end > 65.0
    assert pictures.where_they_differ([Panel("", curves[:1])]) is None
    assert pictures.where_they_differ([Panel("", [curves[0], curves[0]])]) is None


@pytest.mark.parametrize("kind,columns,words", [("gif", 2, "--figures gif"), ("pdf", 3, "--columns 3")])
def test_other_formats_and_widths_are_refused(kind, columns, words):
    with pytest.raises(UsageError, match=words):
        Format(kind, columns)
