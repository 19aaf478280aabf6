// The duty cycle: a time axis whose segments are dragged, and a table in which they are typed.

import { choice, element, field } from "./dom.js";
import { digits } from "./figures.js";
import { frame } from "./plot.js";

const TALL = 170;
const EDGE = { left: 40, right: 14, top: 12, bottom: 24, text: 6 };
const SHORTEST = 10; // s
const DRAWN = { speed: ["speed [rad/s]", 5], torque: ["torque [N.m]", 4] };
const ZERO = 273.15;

/** Columns of the table: name, unit, from SI, to SI. */
const COLUMNS = [
  ["duration", "min", (value) => value / 60, (value) => Math.max(SHORTEST, 60 * value)],
  ["speed", "rad/s", (value) => value, (value) => Math.max(0, value)],
  ["torque", "N.m", (value) => value, (value) => Math.max(0, value)],
  ["ambient_temperature", "°C", (value) => value - ZERO, (value) => value + ZERO],
  ["pad_temperature", "°C", (value) => value - ZERO, (value) => value + ZERO],
  ["pad_power", "W", (value) => value, (value) => Math.max(0, value)],
];

export class DutyEditor {
  /** An editor in a place that holds a `figure`, a `tbody` and a `.choices`; `model` has state and `setSegments`. */
  constructor(place, model, drivers) {
    Object.assign(this, { model, drivers, drawn: "speed", joint: 0, drag: null, rows: -1 });
    this.figure = place.querySelector("figure");
    this.body = place.querySelector("tbody");
    const joints = drivers.map((name, i) => [i, name.replace(/\.?duty$/, "") || name]);
    const pick = (key, options, label) =>
      choice({ "aria-label": label }, options, () => this[key], (value) => { this[key] = key === "joint" ? Number(value) : value; this.rows = -1; this.show(); });
    place.querySelector(".choices").append(
      pick("drawn", Object.entries(DRAWN).map(([name, [text]]) => [name, text]), "what the time axis shows"),
      ...(drivers.length > 1 ? [pick("joint", joints, "which joint")] : []),
    );
    this.figure.addEventListener("pointerdown", (event) => this.begin(event));
    this.figure.addEventListener("pointermove", (event) => this.move(event));
    this.figure.addEventListener("pointerup", () => { this.drag = null; this.show(); });
  }

  /** The demand of a segment on the joint that is shown; the surroundings are those of all joints. */
  value(segment, name) {
    return name === "duration" ? segment.duration : segment[name][this.joint];
  }

  /** Segments with one value changed. */
  changed(index, name, value) {
    return this.model.state.segments.map((segment, i) => {
      if (i !== index) return segment;
      if (name === "duration") return { ...segment, duration: value };
      const own = name === "speed" || name === "torque";
      return { ...segment, [name]: segment[name].map((each, joint) => (own && joint !== this.joint ? each : value)) };
    });
  }

  show() {
    const { segments } = this.model.state;
    if (this.rows !== segments.length) this.tabulate(segments);
    this.draw(segments);
  }

  tabulate(segments) {
    this.rows = segments.length;
    const cell = (index, [name, unit, from, to]) =>
      element("td", {}, field({ "aria-label": `segment ${index + 1}: ${name.replaceAll("_", " ")} [${unit}]` },
        () => digits(from(this.value(this.model.state.segments[index], name))), (value) => this.model.setSegments(this.changed(index, name, to(value)))));
    const pads = [[0, "none"], [1, "power"], [2, "temperature"]];
    const rows = segments.map((_, i) =>
      element("tr", {}, element("th", { scope: "row" }, String(i + 1)), ...COLUMNS.slice(0, 4).map((column) => cell(i, column)),
        element("td", {}, choice({ "aria-label": `segment ${i + 1}: heating pad` }, pads, () => this.value(this.model.state.segments[i], "pad_mode"),
          (mode) => this.model.setSegments(this.changed(i, "pad_mode", Number(mode))))),
        ...COLUMNS.slice(4).map((column) => cell(i, column)),
        element("td", {},
          element("button", { type: "button", "aria-label": `split segment ${i + 1}`, click: () => this.split(i) }, "+"),
          element("button", { type: "button", "aria-label": `remove segment ${i + 1}`, click: () => this.remove(i) }, "−"))));
    this.body.replaceChildren(...rows);
  }

  split(index) {
    const half = this.changed(index, "duration", this.model.state.segments[index].duration / 2);
    this.model.setSegments(half.toSpliced(index, 0, half[index]));
  }

  remove(index) {
    if (this.rows > 1) this.model.setSegments(this.model.state.segments.toSpliced(index, 1));
  }

  draw(segments) {
    const [label, least] = DRAWN[this.drawn];
    const length = segments.reduce((sum, { duration }) => sum + duration, 0);
    const span = this.drag?.span ?? (this.model.state.repeat ? length : Math.max(length, this.model.state.stop));
    const top = this.drag?.top ?? Math.max(least, 1.2 * Math.max(...segments.map((each) => this.value(each, this.drawn))));
    const { x, y, unit, scale, svg } = frame(this.figure, TALL, EDGE, span, [0, top, 4]);
    Object.assign(this, { span, top, scale });
    let time = 0;
    const bars = segments.map((segment, i) => {
      const [left, height] = [x(time), y(this.value(segment, this.drawn))];
      time += segment.duration;
      return `<rect class="bar" x="${left}" width="${x(time) - left}" y="${height}" height="${TALL - EDGE.bottom - height}"/>` +
        `<rect class="handle" data-kind="${this.drawn}" data-segment="${i}" x="${left}" width="${x(time) - left}" y="${height - 9}" height="18"/>` +
        `<line class="top" x1="${left}" x2="${x(time)}" y1="${height}" y2="${height}"/>` +
        `<line class="edge" x1="${x(time)}" x2="${x(time)}" y1="${EDGE.top}" y2="${TALL - EDGE.bottom}"/>` +
        `<rect class="handle side" data-kind="duration" data-segment="${i}" x="${x(time) - 7}" width="14" y="${EDGE.top}" height="${TALL - EDGE.bottom - EDGE.top}"/>`;
    });
    svg(`${label} over time in ${unit}: ${segments.length} segments, which the table below lists`, ...bars);
  }

  begin(event) {
    const { kind, segment } = event.target.dataset;
    if (kind === undefined) return;
    this.figure.setPointerCapture(event.pointerId);
    const index = Number(segment);
    const start = this.value(this.model.state.segments[index], kind);
    this.drag = { kind, index, start, x: event.clientX, y: event.clientY, span: this.span, top: this.top };
    event.preventDefault();
  }

  move(event) {
    if (!this.drag) return;
    const { kind, index, start, x, y } = this.drag;
    const value = kind === "duration"
      ? Math.max(SHORTEST, 10 * Math.round((start + (event.clientX - x) * this.scale.time) / 10))
      : Math.max(0, Number((start + (y - event.clientY) * this.scale.value).toFixed(2)));
    this.model.setSegments(this.changed(index, kind, value));
  }
}
