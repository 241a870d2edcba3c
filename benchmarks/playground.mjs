// Processor time of a flight in the playground, in node: node benchmarks/playground.mjs PAGE.html
//
// Prints for each law, plant and case the median of nine flights (ms), and with the metrics and curves of the page.
import { readFile } from "node:fs/promises";
import vm from "node:vm";

const page = await readFile(process.argv[2], "utf8");
const part = id => page.match(new RegExp(`id="${id}">([^]*?)</script>`))[1];
const about = JSON.parse(part("about"));
globalThis.document = {}; // else the scripts take this for a worker
vm.runInThisContext(`${part("engine")}; globalThis.engine = { flown, answer, compiled };`);
const { flown, answer, compiled } = globalThis.engine, flying = await compiled(about.module);

function median(run) {
  const times = [];
  for (let i = 0; i < 9; i++) {
    const before = process.cpuUsage().user;
    run();
    times.push((process.cpuUsage().user - before) / 1000);
  }
  return times.sort((a, b) => a - b)[4].toFixed(0);
}

for (const [law, { fmu, preset }] of Object.entries(about.laws))
  for (const plant of Object.keys(about.plants))
    for (const name of ["case1", "case2"]) {
      const values = { scenario: about.fmus[about.scenario.fmu].presets[name], controller: about.fmus[fmu].presets[preset],
                       plant: {} };
      const request = { law, plant, step: about.step, stop: about.scenarios[name].stop, values };
      console.log(law, plant, name, median(() => flown(about, flying, request)),
                  median(() => answer(about, flying, request)));
    }
