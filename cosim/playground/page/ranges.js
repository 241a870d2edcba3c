"use strict";
// Where sliders go.

const inside = share => Math.min(1, Math.max(0, share));

// The way of the slider of the parameter `name`, in shown units: `at` a share of it, 0 to 1, and the `share` of a
// value. Its ends are those in `how` or layout.json, else a fifth of the preset's value and five times that, which it
// passes evenly in the logarithm; within the limits that the FMU declares.
function travelOf(about, state, name, how, view) {
  const variable = variableOf(about, state, name);
  const said = about.layout.ranges.find(([pattern]) => new RegExp(pattern).test(name.split(".")[1])) ?? [];
  let [low, high] = [how.low ?? said[1], how.high ?? said[2]];
  const found = low === undefined;
  if (found) {
    const base = usual(about, { ...state, set: {} }, name);
    [low, high] = base === 0 ? [0, 1] : [base / 5, base * 5].sort((a, b) => a - b);
  }
  if (!how.period) {
    low = view.to(Math.max(low, variable.min ?? -Infinity));
    high = view.to(Math.min(high, variable.max ?? Infinity));
  }
  if (!found || low <= 0) {
    return { at: share => low + (high - low) * share, share: x => inside((x - low) / (high - low)) };
  }
  return {
    at: share => low * (high / low) ** share,
    share: x => (x > 0 ? inside(Math.log(x / low) / Math.log(high / low)) : 0),
  };
}
