"use strict";
// What a flight was, in words and figures.

// A sentence for the heading.
function outcome(flight) {
  return flight.finished ? `Flew all ${figure(flight.stop)} s` : `Departed at ${figure(flight.reached, 6)} s`;
}

// A name that may be broken after its dots and underscores.
function breakable(name) {
  return name.split(/(?<=[._])/).flatMap(part => [make("wbr"), part]);
}

function showFlight(about, flight, last) {
  at("view").className = flight.finished ? "flown" : "departed";
  at("outcome").textContent = outcome(flight);
  const error = flight.metrics["altitude_error_ft.max_abs"],
    travel = flight.metrics["elevator_deg.travel"];
  const took = `computed in ${Math.round(flight.took)} ms`;
  const figures = `Largest altitude error ${figure(error)} ft, elevator travel ${figure(travel)}°, ${took}.`;
  at("why").textContent = [flight.message, ...flight.remarks, figures].filter(Boolean).join(" ");
  const rows = [
    ["departed_at_s", "s", flight.finished ? null : flight.reached, last && (last.finished ? null : last.reached)],
    ...Object.entries(flight.metrics).map(([name, value]) => [
      name,
      about.metrics[name].unit,
      value,
      last?.metrics[name],
    ]),
  ];
  at("metrics").replaceChildren(
    make(
      "thead",
      {},
      make(
        "tr",
        {},
        ...["figure", "unit", "this flight", "the last one"].map(textContent =>
          make("th", { scope: "col", textContent }),
        ),
      ),
    ),
    make(
      "tbody",
      {},
      ...rows.map(([name, unit, value, before]) =>
        make(
          "tr",
          {},
          make("th", { scope: "row" }, ...breakable(name)),
          make("td", { textContent: unit === "1" ? "" : unit }),
          make("td", { textContent: figure(value, 5) }),
          make("td", { textContent: figure(before, 5) }),
        ),
      ),
    ),
  );
}

function showRefusal(text) {
  at("view").className = "refused";
  at("outcome").textContent = "Not flown";
  at("why").textContent = text;
}

// Tells screen readers, when nothing more has changed for a moment.
let speech;
function speak(text) {
  clearTimeout(speech);
  speech = setTimeout(() => {
    at("spoken").textContent = text;
  }, 700);
}

// Puts the text of a box on the clipboard; where that is not to be had, selects it.
async function copy(box, button, done) {
  const words = button.textContent;
  box.select();
  try {
    await navigator.clipboard.writeText(box.value);
    button.textContent = done;
  } catch {
    button.textContent = document.execCommand("copy") ? done : "Selected: copy it";
  }
  at("spoken").textContent = button.textContent;
  setTimeout(() => {
    button.textContent = words;
  }, 2000);
}
