"use strict";
// How values look, and elements of the page. Text goes into the page as text, never as markup.

// An element: make("p", {class: "x", textContent: "y"}, child, ...). Names with a dash or of ATTRIBUTES are attributes.
const ATTRIBUTES = new Set(["class", "role", "for", "scope", "colspan"]);
function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties))
    if (name.includes("-") || ATTRIBUTES.has(name)) element.setAttribute(name, value);
    else element[name] = value;
  element.append(...children);
  return element;
}

const at = id => document.getElementById(id);

// How a parameter is shown: its unit, and the way there and back.
function viewOf(variable, period) {
  if (period)
    return {
      unit: "s",
      to: omega => (omega > 0 ? (2 * Math.PI) / omega : Infinity),
      from: seconds => (2 * Math.PI) / seconds,
    };
  if (variable.display) {
    const [unit, factor] = variable.display;
    return { unit, to: value => value * factor, from: shown => shown / factor };
  }
  return { unit: variable.unit, to: value => value, from: shown => shown };
}

// A number for people: so many digits, and no exponent below a million.
function figure(value, digits = 4) {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value);
  return (size >= 10 ** digits && size < 1e6 ? String(Math.round(value)) : short(value, digits)).replace("-", "−");
}
