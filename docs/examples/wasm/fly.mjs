// Flies a system of FMUs as WebAssembly modules: node fly.mjs SYSTEM.json
//
// {"step": s, "stop": s, "components": {NAME: {"module": FILE, "values": {...}, "outputs": [...]}},
//  "connections": [[FROM, TO, [VARIABLE, ...]], ...]}; components step in their order, each from the values that
// those before it have just reached. Prints a JSON row of all outputs for each communication point.
import { readFile } from "node:fs/promises";
import { Fmu } from "./fmu.mjs";

const system = JSON.parse(await readFile(process.argv[2]));
const fmus = {}, shown = {}, links = {};
for (const [name, { module, values, outputs }] of Object.entries(system.components)) {
  fmus[name] = await Fmu.load(await readFile(module));
  fmus[name].begin(values);
  shown[name] = fmus[name].ports(outputs);
  links[name] = system.connections.filter(([, to]) => to === name)
    .map(([from, , names]) => [fmus[from]?.ports(names) ?? from, fmus[name].ports(names), names]);
}
for (const pairs of Object.values(links)) // from components that come later
  for (const pair of pairs) if (typeof pair[0] === "string") pair[0] = fmus[pair[0]].ports(pair[2]);

function tick(advance) {
  for (const [name, fmu] of Object.entries(fmus)) {
    for (const [from, to] of links[name]) to.set(from.get());
    advance(fmu);
  }
  console.log(JSON.stringify(Object.values(shown).flatMap(ports => [...ports.get()])));
}

tick(fmu => fmu.call("ExitInitializationMode"));
const ticks = Math.round(system.stop / system.step);
for (let k = 0; k < ticks; k++) tick(fmu => fmu.step(k * system.step, system.step));
