"use strict";
function option(value, text, chosen = false) { return made("option", {value, selected: chosen}, text); }

function begin() {
  one("explore").hidden = false;
  one("variant").replaceChildren(...VARIANTS.map(({name}, v) => option(v, name)));
  one("variant").parentElement.hidden = VARIANTS.length < 2;
  one("beside").parentElement.hidden = VARIANTS.length < 2;
  const first = Math.max(0, PAGE.metrics.findIndex(({name}) => name === PAGE.metric));
  look_at.m = first;
  one("figure").replaceChildren(...PAGE.metrics.map((figure, m) => option(m, named(figure), m === first)));
  one("figure").parentElement.hidden = !PAGE.metrics.length;
  one("few").parentElement.hidden = !VARIANTS.some(({strongest}) => strongest.length > 4);
  one("which-runs").replaceChildren(option("all", "all"), option("failures", "failures"), option("successes", "successes"),
    ...(PAGE.criteria.length > 1 ? PAGE.criteria.map(({name}, i) => option(`not ${i}`, `not met: ${name}`)) : []),
    ...(PAGE.statuses.length > 1 ? PAGE.statuses.map((how) => option(`status ${how}`, how)) : []));
  one("pick").addEventListener("submit", (event) => { event.preventDefault(); open_number(); });
  one("variant").addEventListener("change", () => { look_at.v = Number(one("variant").value); listing.page = 0; scatter(); });
  one("figure").addEventListener("change", () => { look_at.m = Number(one("figure").value); listing.page = 0; scatter(); });
  one("few").addEventListener("change", () => { look_at.few = one("few").value === "few"; scatter(); });
  one("drag").addEventListener("change", () => {
    for (const {plot, zoom, pan} of look_at.panels) plot.toolbar.active_drag = one("drag").value === "pan" ? pan : zoom;
  });
  one("reset").addEventListener("click", whole_cloud);
  one("which-runs").addEventListener("change", () => { listing.page = 0; list(); });
  one("by-worst").addEventListener("click", () => { Object.assign(listing, {by: "worst", page: 0}); list(); });
  for (const [id, change] of [["earlier", -1], ["later", 1]])
    one(id).addEventListener("click", () => { listing.page += change; list(); });
  for (const [id, change] of [["worse", -1], ["better", 1]])
    one(id).addEventListener("click", () => {
      const {worst, rank} = VARIANTS[opened.v];
      open_run(opened.v, worst[rank[opened.place] + change]);
    });
  one("beside").addEventListener("change", draw_curves);
  one("copy").addEventListener("click", copy);
  for (const button of document.querySelectorAll("button[data-run]")) {  // in the tables that need no script
    const place = FLOWN.indexOf(Number(button.dataset.run));
    button.disabled = place < 0;
    button.addEventListener("click", () => { open_run(Number(button.dataset.variant), place); one("opened").scrollIntoView({block: "start"}); });
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (!state.printing) { scatter(); draw_overview(); } });
  addEventListener("keydown", (event) => { if (event.key === "Escape") one("hover").hidden = true; });
  addEventListener("beforeprint", () => { state.printing = true; });
  addEventListener("afterprint", () => { state.printing = false; });
  scatter().then(() => open_run(0, VARIANTS[0].worst[0], false)).then(draw_overview);
}
if (FLOWN.length) begin();
