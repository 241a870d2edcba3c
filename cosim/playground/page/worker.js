"use strict";
// Answers requests to fly, in a worker or in the page.

// The flight of {law, plant, step, stop, values: {component: {variable: value}}}, with all its signals.
function flown(about, engine, { law, plant, step, stop, values }) {
  const plan = about.plans[law][plant],
    limits = about.limits.flat();
  const fmus = { scenario: about.scenario.fmu, controller: about.laws[law].fmu, plant: about.plants[plant].fmu };
  const components = Object.fromEntries(
    Object.entries(fmus).map(([name, fmu]) => [
      name,
      { fmu, label: `${name} (${about.fmus[fmu].file})`, values: values[name] },
    ]),
  );
  const inquire = {
    plant: ["V_start", "h_start", "fuel_ratio_trim", "elevator_trim", "trim_residual"],
    controller: limits,
  };
  const flight = fly(engine, { components, plan, step, stop, inquire }, about.program);
  return { ...flight, standsIn: about.stands_in };
}

// What an expression is worth, in memory of its own.
function kept(flight, expression) {
  const values = worth(flight, expression);
  return typeof expression === "string" && values ? values.slice() : values;
}

// What the page shows of it: `series` by their lines' signals, metrics, what happened, how long it took (ms).
function answer(about, engine, request) {
  const began = performance.now(),
    flight = flown(about, engine, request),
    took = performance.now() - began;
  const found = metrics(flight, about.metrics);
  const lines = about.layout.panels.flatMap(panel => panel.lines);
  return {
    series: Object.fromEntries(lines.map(line => [line.signal, kept(flight, line.expression)])),
    metrics: found,
    step: flight.step,
    stop: flight.stop,
    count: flight.count,
    finished: flight.finished,
    took,
    asked: flight.asked,
    message: flight.finished
      ? ""
      : [flight.message.replace(/\.$/, "") + ".", stuck(flight, about.remarks)].join(" ").trim(),
    remarks: remarks(flight, found, about.remarks),
    reached: (flight.count - 1) * flight.step,
  };
}

// The engine from the base64 text of its module.
async function compiled(text) {
  return new Engine(await WebAssembly.compile(Uint8Array.from(atob(text), letter => letter.charCodeAt(0))));
}

if (typeof document === "undefined") {
  let ready;
  self.onmessage = async ({ data: { about, request, id } }) => {
    if (about) {
      ready = compiled(about.module).then(engine => ({ about, engine }));
      return;
    }
    try {
      const { about, engine } = await ready,
        result = answer(about, engine, request);
      self.postMessage({ id, result }, [...new Set(Object.values(result.series).map(one => one.buffer))]);
    } catch (error) {
      self.postMessage({ id, error: error.message });
    }
  };
}
