"""Small pictures of a listed run, in its row of the report: each signal over time as a line of an inline SVG."""
from html import escape

import numpy as np

WIDTH, HEIGHT, MOST_POINTS = 220, 70, 200


def small(label: str, time: np.ndarray, values: np.ndarray) -> str:
    """A picture of `values` over `time` (s), both of shape (rows,), as HTML, with its name and its ends in words. Of
    many rows the least and the largest value of each stretch are drawn; empty without a finite value."""
    time, values = thinned(time[np.isfinite(values)], values[np.isfinite(values)])
    if not len(time):
        return ""
    low, high = float(values.min()), float(values.max())
    x = (time - time[0]) / max(time[-1] - time[0], 1e-300) * WIDTH
    y = HEIGHT - (values - low) / max(high - low, 1e-300) * HEIGHT
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y))
    ends = f"{low:.4g} to {high:.4g}, {time[0]:.4g} to {time[-1]:.4g} s"
    name = escape(label, quote=True)
    return (f"<figure><svg viewBox='0 -2 {WIDTH} {HEIGHT + 4}' role=img aria-label='{name}: {ends}'>"
            f"<polyline points='{points}'/></svg><figcaption>{name}<br>{ends}</figcaption></figure>")


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same, or where there are more than MOST_POINTS rows, the least and the largest value of each stretch."""
    if len(time) <= MOST_POINTS:
        return time, values
    chosen: set[int] = {0, len(time) - 1}
    for part in np.array_split(np.arange(len(time)), MOST_POINTS // 2):
        chosen |= {int(part[np.argmin(values[part])]), int(part[np.argmax(values[part])])}
    rows = sorted(chosen)
    return time[rows], values[rows]
