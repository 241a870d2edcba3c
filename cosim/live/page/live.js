const TOKEN = location.search, RETRIES = 3, PATIENCE = 2000;  // ms without news, as when a call of an FMU hangs
const calm = matchMedia("(prefers-reduced-motion: reduce)");
const state = {about: null, columns: new Map(), row: null, late: [0, 0], wanted: {}, made: [], end: null, fresh: false, heard: 0,
               drawn: -Infinity, gauges: [], levers: [], charts: null, failed: 0, lost: false};

function show(name) {  // how a signal is shown: its unit, and its value in that
  const {unit, factor, offset} = state.about.signals[name];
  return {unit, of: (value) => (value === null ? null : factor * value + offset)};
}

function reader(row) {
  return (name) => (state.columns.has(name) ? show(name).of(row[state.columns.get(name)]) : null);
}

function begin(about) {
  state.about = about;
  state.columns = new Map(about.columns.map((name, i) => [name, i + 1]));
  if (state.charts) { state.charts.clear(); return; }  // connected again: everything is told anew
  one("notes").replaceChildren(...about.notes.map((text) => made("p", {class: "note"}, text)));
  state.gauges = about.gauges.map((gauge) => new Gauge(gauge, show));
  one("gauges").replaceChildren(...state.gauges.map(({element}) => element));
  state.levers = about.levers.map((lever) => new Lever(lever));
  one("levers").replaceChildren(...state.levers.map(({element}) => element));
  one("desk").hidden = !about.levers.length;
  state.charts = new Charts(one("charts"), about.charts, about.stop, show);
  one("window").addEventListener("change", () => {
    state.charts.window = Number(one("window").value);
    state.charts.draw();
  });
}

function amount(input, offset) {  // an offset in words: of a factor in per cent
  const unit = state.about.signals[input]?.unit, value = unit === "1" ? 100 * offset : offset;
  const text = `${value > 0 ? "+" : ""}${signed(String(Number(value.toPrecision(4))))}`;
  return unit === "1" ? `${text} %` : `${text} ${unit || ""}`.trim();
}

// The buttons of one input. An offset is asked for, not a change of it: pressing twice in two tabs is no trouble.
class Lever {
  constructor({title, input, step, most}) {
    Object.assign(this, {title, input, step, most, wanted: 0, waiting: 0});
    this.told = made("output", {"aria-live": "off"}, "–");
    const button = (text, label, next) => made("button", {type: "button", "aria-label": label,
      onclick: () => this.ask(next())}, text);
    const round = (value) => Number(value.toPrecision(9));
    this.buttons = [
      button(amount(input, -step), `${title} ${amount(input, -step)}`, () => round(this.wanted - step)),
      button("Back", `${title} back`, () => 0),
      button(amount(input, step), `${title} ${amount(input, step)}`, () => round(this.wanted + step))];
    this.element = made("fieldset", {}, made("legend", {}, title), ...this.buttons, this.told);
  }

  async ask(value) {
    one("refused").textContent = "";
    if (state.end || state.lost) { one("refused").textContent = "The flight is over: nothing can be stepped."; return; }
    const before = this.wanted;
    this.wanted = value;
    this.waiting++;
    try {
      const answer = await fetch(`step${TOKEN}`, {method: "POST", headers: {"Content-Type": "application/json"},
        body: JSON.stringify({input: this.input, value})});
      if (answer.ok) return;
      one("refused").textContent = (await answer.json()).error;
    } catch { one("refused").textContent = "ahv does not answer: the step was not made."; }
    finally { this.waiting--; }
    this.wanted = before;
  }

  set(row) {
    const value = row(this.input), over = Boolean(state.end) || state.lost;
    const text = `${this.wanted ? amount(this.input, this.wanted) : "as the scenario has it"}; now ${figure(value, 3)}`;
    if (this.told.textContent !== text) this.told.textContent = text;
    [this.wanted - this.step < -this.most - 1e-9, !this.wanted, this.wanted + this.step > this.most + 1e-9]
      .forEach((disabled, i) => this.buttons[i].setAttribute("aria-disabled", String(over || disabled)));
  }
}

function say(text, bad) {  // only what is new: it is read out
  if (one("state").textContent !== text) one("state").textContent = text;
  one("state").classList.toggle("bad", bad);
}

function tell() {
  const {end, about} = state;
  document.documentElement.dataset.state = state.lost ? "lost" : end ? (end.written ? "written" : "ended") : "flying";
  if (end) {
    const how = end.trouble ? end.trouble : end.finished ? `The flight ended at ${signed(String(Number(end.reached.toPrecision(7))))} s.${end.message ? ` ${end.message}` : ""}`
      : end.interrupted ? end.message : `Departed at ${Number(end.reached.toPrecision(7))} s: ${end.message}`;
    const where = end.written ? ` The results are in ${end.written}; report.html there has the whole flight. This page keeps the end; it is no longer connected.`
      : end.trouble ? "" : " The results are being written.";
    say(`${how}${where}`, !end.finished);
  } else if (state.lost) say("The connection to ahv is lost: the command has ended, or was stopped. What is shown is the last that came.", true);
  else if (about) say(`Flying, at ${about.factor === 1 ? "the pace of the clock" : `${about.factor} times the pace of the clock`}, to ${about.stop} s.`, false);
  one("count").textContent = `(${state.made.length})`;
}

function draw(now) {
  requestAnimationFrame(draw);
  if (state.row && !state.end && !state.lost && now - state.heard > PATIENCE) {
    const text = `no new values for ${Math.floor((now - state.heard) / 1000)} s`;
    if (one("pace").textContent !== text) one("pace").textContent = text;
  }
  if (!state.fresh || now - state.drawn < (calm.matches ? 1000 : 45)) return;
  state.fresh = false;
  state.drawn = now;
  if (state.row) {
    const row = reader(state.row);
    one("time").textContent = `${state.row[0].toFixed(2)} s`;
    one("pace").textContent = `late by ${(1000 * Math.max(0, state.late[0])).toFixed(1)} ms, at worst ${(1000 * Math.max(0, state.late[1])).toFixed(1)} ms`;
    for (const part of [...state.gauges, ...state.levers]) part.set(row);
    state.charts.draw();
  }
  tell();
}

function list(steps) {
  if (steps.length === state.made.length) return;
  state.made = steps;
  state.charts.marks = steps;
  const titles = new Map(state.about.levers.map(({input, title}) => [input, title]));
  one("made").replaceChildren(...steps.map(({time, input, value}) => made("li", {},
    `${time.toFixed(2)} s: ${titles.get(input) || input} ${value ? amount(input, value) : "back"}`)));
}

const events = new EventSource(`events${TOKEN}`);
events.onmessage = ({data}) => {
  const {about, rows, made: steps, wanted, late, end} = JSON.parse(data);
  if (about) begin(about);
  Object.assign(state, {late, end, fresh: true, failed: 0, lost: false, heard: performance.now()});
  for (const lever of state.levers) if (lever.input in wanted && !lever.waiting) lever.wanted = wanted[lever.input];
  for (const row of rows) state.charts.add(row[0], reader(row));
  if (rows.length) state.row = rows[rows.length - 1];
  list(steps);
  if (end && (end.written || end.trouble)) events.close();
};
events.onerror = () => {  // the browser connects again by itself, unless it was refused
  if (events.readyState !== EventSource.CLOSED && ++state.failed <= RETRIES) return;
  events.close();
  state.lost = !state.end || !state.end.written;
  state.fresh = true;
  if (!state.about) say("ahv did not accept this page: the address is an old one, or too many pages are open.", true);
};
requestAnimationFrame(draw);
