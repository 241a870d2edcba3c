// Processor time of a flight in the playground, in node: node benchmarks/playground.mjs PAGE.html
//
// Prints for each law, plant and case the least of 15 flights (ms), and with the metrics and curves of the page.
import { readFile } from "node:fs/promises";
import vm from "node:vm";

const page = await readFile(process.argv[2], "utf8");
const part = id => page.match(new RegExp(`id="${id}">([^]*?)</script>`))[1];
const about = JSON.parse(part("about"));
globalThis.document = {}; // else the scripts take this for a worker
vm.runInThisContext(`${part("engine")}; globalThis.engine = { flown, answer, compiled };`);
const { flown, answer, compiled } = globalThis.engine, flying = await compiled(about.module);

function least(run) {
  const times = Array.from({ length: 15 }, () => {
    const before = process.cpuUsage().user;
    run();
    return (process.cpuUsage().user - before) / 1000;
  });
  return Math.min(...times).toFixed(0);
}

for (const [law, { fmu, preset }] of Object.entries(about.laws))
  for (const plant of Object.keys(about.plants))
    for (const name of ["case1", "case2"]) {
      const values = { scenario: about.fmus[about.scenario.fmu].presets[name], controller: about.fmus[fmu].presets[preset],
                       plant: {} };
      const request = { law, plant, step: about.step, stop: about.scenarios[name].stop, values };
      console.log(law, plant, name, least(() => flown(about, flying, request)),
                  least(() => answer(about, flying, request)));
    }
