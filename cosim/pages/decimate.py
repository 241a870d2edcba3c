"""Fewer points for the same picture: of each part of the rows the least and the greatest value."""
import base64
from collections.abc import Sequence

import numpy as np

SMALL, LARGE = 1e-30, 1e30  # what 32-bit floats hold with all their digits
CLOSE = 1e-3  # of the range: a line between kept rows may be so far off, where there is room for more rows
ROUNDS = 6


def kept(values: np.ndarray, points: int) -> np.ndarray:
    """The rows to draw of `values`, shape (rows,): ascending, at most about `points` of them, the first and the last,
    every extreme, both ends of what is not finite, and more where a line between them would be far off. Rows between
    two equal values are left out."""
    count = len(values)
    rows = np.arange(count)
    if count > points:
        size = -(-count // max(points // 4, 1))
        finite = np.isfinite(values)
        parts = np.full((-(-count // size), size), np.nan)
        parts.ravel()[:count][finite] = values[finite]
        low = np.where(np.isnan(parts), np.inf, parts).argmin(axis=1)
        high = np.where(np.isnan(parts), -np.inf, parts).argmax(axis=1)
        begin = np.arange(0, count, size)
        gaps = np.flatnonzero(finite[1:] != finite[:-1])[:points // 8]
        rows = np.unique(np.concatenate(([0, count - 1], begin + low, begin + high, gaps, gaps + 1)))
        rows = nearer(values, rows, points // 2)
    chosen = values[rows]
    level = (chosen[1:-1] == chosen[:-2]) & (chosen[1:-1] == chosen[2:])
    return rows[np.concatenate(([True], ~level, [True]))[:len(rows)]] if len(rows) > 2 else rows


def nearer(values: np.ndarray, rows: np.ndarray, most: int) -> np.ndarray:
    """`rows` with at most `most` others, where a line between two of them is more than CLOSE off: the worst of each
    such line, then of what is left."""
    some = values[rows][np.isfinite(values[rows])]
    every = np.arange(len(values))
    for _ in range(ROUNDS if len(some) else 0):
        with np.errstate(invalid="ignore", over="ignore"):
            off = np.abs(np.interp(every, rows, values[rows]) - values)
            far = np.flatnonzero(off > CLOSE * (some.max() - some.min()))
        far = far[np.argsort(-off[far], kind="stable")]
        found = far[np.sort(np.unique(np.searchsorted(rows, far), return_index=True)[1])][:most]
        if not len(found):
            break
        rows, most = np.union1d(rows, found), most - len(found)
    return rows


def packed(time: np.ndarray, values: np.ndarray, points: int) -> dict[str, object]:
    """A curve for the page's script: times from `time[0]` on and values from `base` on, as base64 of little-endian
    32-bit floats. Differences from a base have the digits that an altitude of 85,000 ft would lose. Differences too
    large or too small for 32 bits are divided by `scale`."""
    rows = kept(values, points)
    chosen = values[rows]
    finite = chosen[np.isfinite(chosen)]
    base = float(np.sort(finite)[len(finite) // 2]) if len(finite) else 0.0  # small values stay exact beside large ones
    with np.errstate(over="ignore"):
        largest = float(np.nan_to_num(np.abs(finite - base)).max(initial=0.0))
    if largest == 0.0 or SMALL < largest < LARGE:
        return {"t": text(time[rows] - time[0]), "y": text(chosen - base), "base": base}
    scale = 2.0 ** min(max(int(np.frexp(largest)[1]), -1021), 1023)
    return {"t": text(time[rows] - time[0]), "y": text(chosen / scale - base / scale), "base": base, "scale": scale}


def text(numbers: np.ndarray, kind: str = "<f4") -> str:
    """Numbers as base64 of little-endian 32-bit floats, or of another `kind` of numpy's."""
    with np.errstate(over="ignore"):
        return base64.b64encode(numbers.astype(kind).tobytes()).decode()


GAP = 65535  # where there is no finite value


def rounded(values: np.ndarray, begins: Sequence[int] | np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Curves one after the other in `values`, which begin at the rows `begins`: the least value and a step of each, and
    how many steps each value lies above the least: whole numbers of 16 bits, which a screen cannot tell from the
    values. GAP where there is no finite value. No curve is empty."""
    if not len(values):
        return np.empty(0), np.empty(0), np.empty(0)
    finite = np.isfinite(values)
    low = np.minimum.reduceat(np.where(finite, values, np.inf).astype(float), begins)
    high = np.maximum.reduceat(np.where(finite, values, -np.inf).astype(float), begins)
    low, high = np.where(low > high, 0.0, low), np.where(low > high, 0.0, high)
    step = np.where(high > low, (high - low) / (GAP - 1), 1.0)
    lengths = np.diff([*begins, len(values)])
    above = (np.where(finite, values, 0.0) - np.repeat(low, lengths)) / np.repeat(step, lengths)
    return low, step, np.where(finite, np.rint(above), GAP)
