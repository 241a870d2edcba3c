"use strict";
// Brings it together: a change of the state is flown, by a worker where there can be one, and shown.

const about = JSON.parse(at("about").textContent);

// Answers requests one after the other; of those that wait, the last one only.
class Pilot {
  constructor(show, complain) {
    Object.assign(this, { show, complain, busy: false, waiting: null, stale: false, id: 0 });
    try {
      const url = URL.createObjectURL(new Blob([at("engine").textContent], { type: "text/javascript" }));
      this.worker = new Worker(url);
      this.worker.onmessage = ({ data }) => this.answered(data);
      this.worker.onerror = event => {
        event.preventDefault();
        this.alone();
      };
      this.worker.postMessage({ about });
    } catch {
      this.alone();
    }
  }

  // No worker: the page itself computes.
  alone() {
    this.worker = null;
    this.engine = compiled(about.module);
    if (this.busy) this.compute(this.busy);
  }

  fly(request) {
    if (this.busy) {
      this.waiting = request;
      return;
    }
    this.busy = request;
    this.id++;
    if (this.worker) this.worker.postMessage({ request, id: this.id });
    else this.compute(request);
  }

  // What is asked for is no longer wanted: no answer to it is shown.
  forget() {
    this.waiting = null;
    this.stale = Boolean(this.busy);
  }

  async compute(request) {
    const id = this.id;
    try {
      this.answered({ id, result: answer(about, await this.engine, request) });
    } catch (error) {
      this.answered({ id, error: error.message });
    }
  }

  answered({ id, result, error }) {
    if (id !== this.id) return;
    const { waiting: next, stale } = this;
    this.busy = this.waiting = null;
    this.stale = false;
    if (!stale) error ? this.complain(error) : this.show(result);
    if (next) this.fly(next);
  }
}

let state,
  shown = null,
  before = null;

const request = state => ({
  law: state.law,
  plant: state.plant,
  step: state.step,
  stop: state.stop,
  values: valuesOf(about, state),
});

const complain = text => {
  showRefusal(text);
  speak(`Not flown. ${text}`);
};

const pilot = new Pilot(result => {
  before = shown ?? result;
  shown = result;
  showFlight(about, shown, before === shown ? null : before);
  charts.show(shown, before === shown ? null : before);
  showWindow();
  document.documentElement.dataset.flights = Number(document.documentElement.dataset.flights ?? 0) + 1;
  speak(`${outcome(shown)}. ${at("why").textContent}`);
}, complain);

const charts = new Charts(at("charts"), about.layout.panels, zoom);

function zoom(from = null, to = null) {
  charts.window = from === null ? null : [Math.max(0, from), Math.min(to, state.stop)];
  charts.draw();
  showWindow();
}

function showWindow() {
  [at("from").value, at("to").value] = charts.span().map(time => Number(time.toFixed(2)));
}

function change(next) {
  if (next.stop !== state?.stop) charts.window = null;
  state = next;
  controls.show(state);
  const wrong = refusal(about, state);
  at("command").value = wrong ? "" : command(about, state);
  at("link").value = wrong ? "" : `${location.href.split("#")[0]}#${toFragment(about, state)}`;
  if (wrong) {
    pilot.forget();
    complain(wrong);
  } else pilot.fly(request(state));
}

const controls = new Controls(at("controls"), about, change, complain);

function fromLink() {
  const { state: found, left } = fromFragment(about, location.hash.slice(1));
  change(found);
  if (left) speak(`${left} ${left === 1 ? "part" : "parts"} of the link could not be used.`);
}

for (const [list, kind] of [
  [about.layout.examples, "main"],
  [about.layout.more_examples, "other"],
])
  for (const { name, state: parts } of list) {
    const button = make("button", { type: "button", class: kind, textContent: name });
    button.addEventListener("click", () => change(fromFragment(about, parts.join("&")).state));
    at("examples").append(button);
  }

const edge = (id, label) =>
  make("label", {}, make("span", { textContent: label }), make("input", { id, type: "number", min: 0, step: "any" }));
at("window").append(
  edge("from", "Curves from (s)"),
  edge("to", "to (s)"),
  make("button", { type: "button", id: "whole", textContent: "Whole flight" }),
);
for (const id of ["from", "to"])
  at(id).addEventListener("change", () => {
    const [from, to] = ["from", "to"].map(id => Number(at(id).value));
    zoom(...(from < to ? [from, to] : []));
  });
at("whole").addEventListener("click", () => zoom());
at("copy-command").addEventListener("click", event => copy(at("command"), event.currentTarget, "Copied"));
at("share").addEventListener("click", event => {
  history.replaceState(null, "", at("link").value);
  copy(at("link"), event.currentTarget, "Link copied");
});
at("version").textContent = `ahv ${about.version}.`;
addEventListener("hashchange", () => {
  if (location.hash !== "#controls") fromLink();
});
fromLink();
