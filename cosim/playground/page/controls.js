"use strict";
// The form: choices, and a slider with a number box for each parameter, made of what the FMUs declare.

const POSITIONS = 1000;

class Controls {
  // `changed(state)` is told of every change; `complain(text)` of what cannot be.
  constructor(form, about, changed, complain) {
    Object.assign(this, { form, about, changed, complain });
    this.opened = new Map();
    form.addEventListener("submit", event => event.preventDefault());
  }

  // Builds the form anew where what can be set has changed, else only sets its values.
  show(state) {
    this.state = state;
    const kind = [state.case, state.law, state.plant, state.preset, state.plantPreset].join(); // what ranges depend on
    if (kind !== this.kind) {
      this.kind = kind;
      const focus = document.activeElement?.id;
      this.rows = [];
      this.form.replaceChildren(
        this.choices(),
        ...this.about.layout.sections.map(section => this.section(section)),
        this.everything(),
      );
      if (focus) at(focus)?.focus();
    }
    this.refresh();
  }

  refresh() {
    for (const update of this.rows) update();
  }

  set(changes) {
    const { about } = this,
      set = { ...this.state.set };
    for (const [name, value] of Object.entries(changes)) {
      if (value === undefined || value === usual(about, this.state, name)) delete set[name];
      else set[name] = value;
    }
    this.changed({ ...this.state, set });
  }

  // --- choices ------------------------------------------------------------------------------------------------

  choices() {
    const { about } = this,
      words = Object.keys;
    const titled = group => words(about[group]).map(word => [word, `${word}: ${about[group][word].summary}`]);
    return make(
      "div",
      { class: "choices" },
      this.select("case", "Case", () =>
        words(about.scenarios).map(word => [word, `${word}, ${about.scenarios[word].stop} s`]),
      ),
      this.select("law", "Control law", () => titled("laws")),
      this.select("preset", "Gains (preset)", () =>
        words(about.fmus[fmuOf(about, this.state, "controller")].presets).map(word => [word, word]),
      ),
      this.select("plant", "Plant", () => titled("plants")),
      this.select("plantPreset", "Coefficients (preset)", () => [
        ["", "as in the paper"],
        ...words(about.fmus[fmuOf(about, this.state, "plant")].presets).map(word => [word, word]),
      ]),
      this.number("step", "Step (s)", 0.001),
      this.number("stop", "End (s)", 1),
    );
  }

  select(key, label, options) {
    const box = make(
      "select",
      { id: `choice-${key}` },
      ...options().map(([value, textContent]) => make("option", { value, textContent })),
    );
    box.addEventListener("change", () => this.changed(chosen(this.about, this.state, key, box.value)));
    this.rows.push(() => {
      box.value = this.state[key];
    });
    return make("label", {}, make("span", { textContent: label }), box);
  }

  number(key, label, step) {
    const box = make("input", { id: `choice-${key}`, type: "number", min: 0, step });
    box.step = "any";
    box.addEventListener("change", () => this.changed({ ...this.state, [key]: Number(box.value) }));
    this.rows.push(() => {
      box.value = this.state[key];
    });
    return make("label", { class: "narrow" }, make("span", { textContent: label }), box);
  }

  // --- sections -----------------------------------------------------------------------------------------------

  section(section) {
    const { about, state } = this,
      fmu = fmuOf(about, state, section.component),
      known = about.fmus[fmu].variables;
    const body = make("div");
    if (section.swings) body.append(...this.swings(section));
    else {
      const names = this.names(section, known);
      body.append(
        ...names
          .filter(name => Object.hasOwn(known, name))
          .map(name => this.row([`${section.component}.${name}`], known[name])),
      );
      if (!names.length && section.without)
        body.append(make("p", { textContent: section.without }), this.instrumented());
    }
    return this.details(section.title, body, section.open, `${section.component}.`);
  }

  names({ variables }, known) {
    const { about, state } = this;
    if (variables === "gains") return about.laws[state.law].gains;
    if (variables === "limits") return about.limits.flat();
    if (variables !== "own") return variables;
    const plain = about.fmus[about.plants.ideal.fmu].variables;
    return Object.keys(known).filter(name => known[name].causality === "parameter" && !Object.hasOwn(plain, name));
  }

  instrumented() {
    const button = make("button", { type: "button", textContent: "Choose the plant “instrumented”" });
    button.addEventListener("click", () => this.changed(chosen(this.about, this.state, "plant", "instrumented")));
    return button;
  }

  details(title, body, open) {
    const box = make(
      "details",
      { open: this.opened.get(title) ?? Boolean(open) },
      make("summary", { textContent: title }),
      body,
    );
    box.addEventListener("toggle", () => this.opened.set(title, box.open));
    return box;
  }

  // For all groups of coefficients together, and for each: amplitude, period and phase.
  swings({ component, swings }) {
    const known = this.about.fmus[this.about.scenario.fmu].variables,
      all = Object.values(swings).flat();
    const group = (title, signals) =>
      make(
        "fieldset",
        {},
        make("legend", { textContent: title }),
        ...this.about.layout.swing.map(({ variable, ...how }) =>
          this.row(
            signals.map(signal => `${component}.${signal}_${variable}`),
            known[`${signals[0]}_${variable}`],
            { ...how, of: title },
          ),
        ),
      );
    const one = this.details(
      "Each group on its own",
      make("div", {}, ...Object.entries(swings).map(([name, signals]) => group(name, signals))),
    );
    return [group("all groups together", all), one];
  }

  // --- a parameter --------------------------------------------------------------------------------------------

  // A slider and a box for the parameters `names`, which move together and are declared as `variable`.
  row(names, variable, how = {}) {
    const [first] = names,
      id = `set-${names.join("+")}`,
      title = how.name ?? first.split(".")[1];
    const view = viewOf(variable, how.period),
      range = travelOf(this.about, this.state, first, how, view);
    const value = () => valuesOf(this.about, this.state)[first.split(".")[0]][first.split(".")[1]] ?? variable.start;
    const give = found => this.set(Object.fromEntries(names.map(name => [name, found])));
    const back = make("button", {
      type: "button",
      class: "back",
      textContent: "↺",
      "aria-label": `${title}${how.of ? ` of ${how.of}` : ""}: back to the preset`,
      title: "back to the preset",
    });
    back.addEventListener("click", () => give(undefined));
    const about = how.name ? "" : variable.description;
    const name = make("label", { for: id }, make("b", { textContent: title }), view.unit ? ` ${view.unit}` : "");
    const head = make("div", { class: "head" }, name, back);
    const note = make("p", { id: `${id}-note`, textContent: about });
    const described = about ? { "aria-describedby": note.id } : {};
    const line = make("div", { class: "row" }, head);
    const changed = () => {
      const moved = names.some(name => Object.hasOwn(this.state.set, name));
      line.classList.toggle("changed", moved);
      back.hidden = !moved;
    };
    if (typeof variable.start === "boolean") {
      const box = make("input", { id, type: "checkbox", ...described });
      box.addEventListener("change", () => give(box.checked));
      this.rows.push(() => {
        box.checked = value();
        changed();
      });
      head.prepend(box);
    } else {
      const box = make("input", { id, type: "number", step: "any", inputMode: "decimal", ...described });
      const slider = make("input", {
        type: "range",
        min: 0,
        max: POSITIONS,
        step: 1,
        "aria-label": `${title}${how.of ? ` of ${how.of}` : ""}, slider`,
      });
      const whole = first.endsWith("noise_seed");
      slider.addEventListener("input", () => {
        const shown = Number(range.at(slider.value / POSITIONS).toPrecision(3));
        give(view.from(whole ? Math.round(shown) : shown));
      });
      box.addEventListener("change", () => {
        const found = box.value.trim() === "" ? NaN : view.from(Number(box.value));
        const wrong = refused(variable, first, found);
        box.setAttribute("aria-invalid", Boolean(wrong));
        if (wrong) this.complain(wrong);
        else give(found);
      });
      this.rows.push(() => {
        const shown = view.to(value());
        if (document.activeElement !== slider) slider.value = POSITIONS * range.share(shown);
        slider.setAttribute("aria-valuetext", `${figure(shown)} ${view.unit}`);
        box.value = Number.isFinite(shown) ? Number(shown.toPrecision(7)) : "";
        box.setAttribute("aria-invalid", "false");
        changed();
      });
      line.append(make("div", { class: "inputs" }, slider, box));
    }
    if (about) line.append(note);
    return line;
  }

  // Every parameter of the three FMUs, as boxes, made when it is opened.
  everything() {
    const body = make("div"),
      box = this.details("Every parameter", body, false);
    const fill = () => {
      if (!box.open || body.childElementCount) return;
      const filter = make("input", { id: "filter", type: "search", placeholder: "mass, noise, lambda …" }),
        lines = [];
      for (const component of COMPONENTS)
        for (const [name, variable] of Object.entries(
          this.about.fmus[fmuOf(this.about, this.state, component)].variables,
        ))
          if (variable.causality === "parameter")
            lines.push([
              `${component}.${name} ${variable.description}`.toLowerCase(),
              this.plain(`${component}.${name}`, variable),
            ]);
      filter.addEventListener("input", () => {
        for (const [text, line] of lines) line.hidden = !text.includes(filter.value.toLowerCase());
      });
      body.append(make("label", { for: "filter", textContent: "Find" }), filter, ...lines.map(([, line]) => line));
      this.refresh();
    };
    box.addEventListener("toggle", fill);
    fill();
    return box;
  }

  // A box alone, in the FMU's own unit.
  plain(name, variable) {
    const id = `every-${name}`,
      truth = typeof variable.start === "boolean",
      [component, word] = name.split(/\.(.*)/s);
    const box = make("input", truth ? { id, type: "checkbox" } : { id, type: "number", step: "any" });
    box.addEventListener("change", () => {
      const found = truth ? box.checked : box.value.trim() === "" ? NaN : Number(box.value),
        wrong = refused(variable, name, found);
      box.setAttribute("aria-invalid", Boolean(wrong));
      if (wrong) this.complain(wrong);
      else this.set({ [name]: found });
    });
    this.rows.push(() => {
      const value = valuesOf(this.about, this.state)[component][word] ?? variable.start;
      if (truth) box.checked = value;
      else box.value = value;
    });
    return make(
      "div",
      { class: "plain" },
      make(
        "label",
        { for: id },
        make("b", { textContent: name }),
        ` ${variable.unit || ""} `,
        make("small", { textContent: variable.description }),
      ),
      box,
    );
  }
}
