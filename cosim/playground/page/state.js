"use strict";
// What is flown, as data: {case, law, plant, preset, plantPreset, step, stop, set: {"component.variable": value}}.
// Pure functions from it to values, to the command that repeats the flight, and to the part of a link and back.

const COMPONENTS = ["scenario", "controller", "plant"];
const MOST_STEPS = 600000; // rows that a browser's memory takes easily

function fmuOf(about, state, component) {
  return { scenario: about.scenario, controller: about.laws[state.law], plant: about.plants[state.plant] }[component]
    .fmu;
}

function variableOf(about, state, name) {
  const [component, variable] = name.split(/\.(.*)/s);
  if (!COMPONENTS.includes(component)) return undefined;
  const known = about.fmus[fmuOf(about, state, component)].variables;
  return Object.hasOwn(known, variable) && known[variable].causality === "parameter" ? known[variable] : undefined;
}

function startState(about, law = "neural") {
  return {
    case: "case1",
    law,
    plant: "ideal",
    preset: about.laws[law].preset,
    plantPreset: "",
    step: about.step,
    stop: about.scenarios.case1.stop,
    set: {},
  };
}

// The presets that fly, by component.
function presets(about, state) {
  const chosen = {
    scenario: about.scenarios[state.case].presets.scenario,
    controller: state.preset,
    plant: state.plantPreset,
  };
  return Object.fromEntries(
    COMPONENTS.map(name => [name, (chosen[name] && about.fmus[fmuOf(about, state, name)].presets[chosen[name]]) || {}]),
  );
}

// The values that are set, by component: the user's over what follows a start over the presets'.
function valuesOf(about, state) {
  const found = presets(about, state);
  for (const name of COMPONENTS) found[name] = { ...found[name] };
  for (const [command, start] of Object.entries(about.follows))
    if (`plant.${start}` in state.set) found.scenario[command] = state.set[`plant.${start}`];
  for (const [name, value] of Object.entries(state.set)) {
    const [component, variable] = name.split(/\.(.*)/s);
    found[component][variable] = value;
  }
  return found;
}

// The value that a parameter has without the user's.
function usual(about, state, name) {
  const values = valuesOf(about, {
    ...state,
    set: Object.fromEntries(Object.entries(state.set).filter(([key]) => key !== name)),
  });
  const [component, variable] = name.split(/\.(.*)/s);
  return values[component][variable] ?? variableOf(about, state, name).start;
}

// Why the state cannot be flown, a sentence; empty if it can.
function refusal(about, state) {
  const { step, stop } = state,
    count = Math.round(stop / step);
  if (!(step > 0 && stop > 0 && Number.isFinite(step) && Number.isFinite(stop)))
    return `The step and the end must be positive numbers of seconds.`;
  if (count < 1 || Math.abs(count * step - stop) > 1e-6 * step)
    return `The end, ${stop} s, is not a whole number of steps of ${step} s.`;
  if (count > MOST_STEPS) return `The flight has ${count} steps; this page flies at most ${MOST_STEPS}.`;
  for (const [name, value] of Object.entries(state.set)) {
    const wrong = refused(variableOf(about, state, name), name, value);
    if (wrong) return wrong;
  }
  const { controller } = valuesOf(about, state),
    declared = about.fmus[fmuOf(about, state, "controller")].variables;
  for (const pair of about.limits) {
    const [low, high] = pair.map(name => controller[name] ?? declared[name].start);
    if (low > high)
      return `controller.${pair[0]} = ${low} is not allowed: it is above controller.${pair[1]} = ${high}.`;
  }
  return "";
}

function refused(variable, name, value) {
  const { min = -Infinity, max = Infinity, unit, start } = variable;
  if (typeof start === "boolean")
    return typeof value === "boolean" ? "" : `${name} = ${value} is not allowed: it is true or false.`;
  if (typeof value === "number" && Number.isFinite(value) && min <= value && value <= max) return "";
  const range = `between ${short(min)} and ${short(max)}${unit ? ` ${unit}` : ""}`;
  return `${name} = ${value} is not allowed: it must be ${range}.`;
}

// The command that repeats the flight.
function command(about, state) {
  const { stop } = about.scenarios[state.case],
    chosen = [];
  if (state.preset && state.preset !== about.laws[state.law].preset)
    chosen.push(state.plantPreset ? `controller=${state.preset}` : state.preset);
  if (state.plantPreset) chosen.push(`plant=${state.plantPreset}`);
  return [
    "ahv run",
    state.case,
    state.law === "neural" ? "" : `--controller ${state.law}`,
    state.plant === "ideal" ? "" : `--plant ${state.plant}`,
    chosen.length ? `--preset ${chosen.join(",")}` : "",
    state.step === about.step ? "" : `--step ${state.step}`,
    state.stop === stop ? "" : `--stop ${state.stop}`,
    ...Object.entries(state.set).map(([name, value]) => `--set ${name}=${value}`),
  ]
    .filter(Boolean)
    .join(" ");
}

const WORDS = { case: "scenarios", law: "laws", plant: "plants" };

function toFragment(about, state) {
  const usual = { ...startState(about, state.law), law: startState(about).law, stop: about.scenarios[state.case].stop };
  const said = ["case", "law", "plant", "preset", "plantPreset", "step", "stop"].filter(
    key => key === "case" || state[key] !== usual[key],
  );
  return new URLSearchParams([...said.map(key => [key, state[key]]), ...Object.entries(state.set)]).toString();
}

// A state from the part of a link, which anybody may have written: what is not known or not allowed is left out, and
// counted in `left`.
function fromFragment(about, text) {
  const said = new Map(new URLSearchParams(text)),
    known = (group, word) => Object.hasOwn(about[group], word);
  let left = 0;
  const take = (key, fits, fallback) => {
    const word = said.get(key);
    said.delete(key);
    if (word === undefined || fits(word)) return word ?? fallback;
    left++;
    return fallback;
  };
  const number = (key, fallback) =>
    Number(take(key, word => word.trim() !== "" && Number(word) > 0 && Number.isFinite(Number(word)), fallback));
  const law = take("law", word => known("laws", word), "neural"),
    state = startState(about, law);
  state.case = take("case", word => known("scenarios", word), state.case);
  state.plant = take("plant", word => known("plants", word), state.plant);
  const has = component => word => Object.hasOwn(about.fmus[fmuOf(about, state, component)].presets, word);
  state.preset = take("preset", has("controller"), state.preset);
  state.plantPreset = take("plantPreset", word => !word || has("plant")(word), "");
  const plain = (state.stop = about.scenarios[state.case].stop);
  state.step = number("step", state.step);
  state.stop = number("stop", state.stop);
  const runs = Math.round(state.stop / state.step);
  if (runs < 1 || runs > MOST_STEPS || refusal(about, state)) {
    left++;
    Object.assign(state, { step: about.step, stop: plain });
  }
  for (const [name, word] of said) {
    const variable = variableOf(about, state, name);
    const value =
      variable &&
      (typeof variable.start === "boolean"
        ? { true: true, false: false }[word]
        : word.trim() === ""
          ? NaN
          : Number(word));
    if (variable && !refused(variable, name, value)) state.set[name] = value;
    else left++;
  }
  return { state: refusal(about, state) ? { ...state, set: {} } : state, left };
}

// The state with another choice: what the new parts do not have is left out.
function chosen(about, state, key, value) {
  const next = { ...state, [key]: value };
  if (key === "case") next.stop = about.scenarios[value].stop;
  if (key === "law") next.preset = about.laws[value].preset;
  if (key === "plant") next.plantPreset = "";
  next.set = Object.fromEntries(
    Object.entries(state.set).filter(([name, given]) => {
      const variable = variableOf(about, next, name);
      const dropped = name.startsWith("controller.") && (key === "law" || key === "preset");
      return variable && !dropped && !refused(variable, name, given);
    }),
  );
  return next;
}
