// What the reader has changed, and the runs that follow from it. A form is the state of the page: each field is named after
// a variable, and shows it in a unit of its own.

import { digits } from "./figures.js";

const unseen = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
unseen.fillStyle = "#0008";

export class Model {
  /** `engines` run the system with each law; `onchange` is called after every change. */
  constructor(form, content, engines, onchange) {
    Object.assign(this, { content, engines, onchange, vectors: content.vectors, measured: null });
    this.fields = new Map([...form.elements].filter(({ dataset }) => dataset.unit).map((field) => [field.name, field]));
    this.start = new Map([...this.fields].map(([name, { dataset }]) => [name, dataset.start ?? this.text(name)]));
    this.rows = Array.from({ length: content.most }, (_, i) => this.vectors.map(({ name }) => `${name}[${i + 1}]`));
    this.score = new Function("v", `return ${content.score}`);
    this.uncompensated = new Function("v", `return ${content.uncompensated}`);
  }

  /** What a field shows. */
  text(name) {
    const { type, checked, value } = this.fields.get(name);
    return type === "checkbox" ? String(Number(checked)) : value;
  }

  /** What a field shows, with its unit. */
  quantity(name) {
    const { unit } = this.fields.get(name).dataset;
    return unit === "1" ? this.text(name) : `${this.text(name)} ${unit}`;
  }

  /** A variable in its SI unit; `text` is what its field shows, by default now. */
  get(name, text = this.text(name)) {
    const { factor, offset } = this.fields.get(name).dataset;
    return (Number(text) - offset) / factor;
  }

  /** What a field shows for a value in SI units. */
  shown(name, value) {
    const { factor, offset } = this.fields.get(name).dataset;
    return digits(factor * value + Number(offset), 12);
  }

  /** Change variables, in SI units. */
  set(values) {
    this.put(Object.fromEntries(Object.entries(values).map(([name, value]) => [name, this.shown(name, value)])));
  }

  /** Change what fields show; null stands for the scenario's value. */
  put(texts) {
    for (const [name, given] of Object.entries(texts)) {
      const [field, text] = [this.fields.get(name), given ?? this.start.get(name)];
      if (field.type === "checkbox") field.checked = text === "1";
      else field.value = text;
    }
    this.onchange();
  }

  /** Names of what was changed, of a kind ("parameter", "duty" or "page") or at all. */
  changed(kind) {
    const all = [...this.fields].filter(([, { disabled, dataset }]) => !disabled && (kind ?? dataset.kind) === dataset.kind);
    return all.map(([name]) => name).filter((name) => Number(this.text(name)) !== Number(this.start.get(name)));
  }

  get laws() {
    return Object.keys(this.content.laws).filter((law) => this.get(`law:${law}`));
  }

  /** What the fields of each segment show, in the order of the vectors; an unused one has no duration. */
  get segments() {
    return this.rows.map((names) => names.map((name) => this.text(name))).filter(([duration]) => duration);
  }

  set segments(segments) {
    if (!segments.length || segments.length > this.rows.length) return;
    const unused = ["", ...this.vectors.slice(1).fill(null)];
    this.rows.forEach((names, i) => this.put(Object.fromEntries(names.map((name, k) => [name, (segments[i] ?? unused)[k]]))));
  }

  /** Values of a law's run by watched variable; `more` are values of variables, in SI units. */
  run(law, more = {}) {
    const { watched, step, laws } = this.content;
    const { references, values } = laws[law];
    const changed = [...this.changed().map((name) => [name, this.get(name)]), ...Object.entries(more)];
    const set = changed.flatMap(([name, value]) => (references[name] ?? []).map((each) => [each, value]));
    const wanted = watched.map((name) => references[name][0]);
    // In Firefox 140 a search in a text or an array leaves the registers of some processors (those with AVX-512) so that
    // WebAssembly runs a hundred times slower, until something translucent is drawn.
    unseen.fillRect(0, 0, 8, 8);
    unseen.getImageData(0, 0, 1, 1);
    const columns = this.engines[law](wanted, Math.round(this.get("stop") / step), step, [...values, ...set]);
    return Object.fromEntries(watched.map((name, i) => [name, columns[i]]));
  }

  /** An expression at every communication point, in m. */
  evaluate(expression, values) {
    return Object.values(values)[0].map((_, i) => expression((name) => values[name][i]));
  }
}
