"use strict";
// Curves with as many points as a screen shows, on times that all curves of a panel share.

const BINS = 600;

// The times of the points from `from` to `to` (s): two in each of the bins.
function grid(from, to, bins = BINS) {
  return Float64Array.from({ length: 2 * bins + 1 }, (_, i) => from + ((to - from) * i) / (2 * bins));
}

// `values` at the times k * step as points at `times`, a grid: as they are there, and in a bin with more extreme ones
// the least and the greatest, in their order. null where there are none.
function decimated(values, step, times, factor = 1) {
  const n = times.length,
    last = values.length - 1,
    found = new Array(n).fill(null);
  for (let i = 0; i < n; i++) {
    const x = times[i] / step,
      k = Math.floor(x + 1e-9),
      share = x - k;
    if (k < last) found[i] = factor * (share > 1e-9 ? values[k] + share * (values[k + 1] - values[k]) : values[k]);
    else if (k === last && share < 1e-6) found[i] = factor * values[k];
  }
  for (let i = 0; i + 2 < n; i += 2) {
    const first = Math.max(0, Math.ceil(times[i] / step - 1e-9)),
      end = Math.min(last, Math.ceil(times[i + 2] / step - 1e-9) - 1);
    if (end - first < 2) continue;
    let low = first,
      high = first;
    for (let k = first + 1; k <= end; k++) {
      if (values[k] < values[low]) low = k;
      if (values[k] > values[high]) high = k;
    }
    const shown = [found[i], found[i + 1], found[i + 2]].filter(y => y !== null).map(y => y / factor);
    if (Math.min(...shown) <= values[low] && values[high] <= Math.max(...shown)) continue;
    found[i] = factor * values[Math.min(low, high)];
    found[i + 1] = factor * values[Math.max(low, high)];
  }
  return found;
}
