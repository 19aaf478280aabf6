// What the reader has chosen, and the runs that follow from it.

import { drawUnseen } from "./dom.js";

/** Demands of a segment, in the names of the DutyCycle component. */
const DEMANDS = ["speed", "torque", "ambient_temperature", "pad_mode", "pad_temperature", "pad_power"];

export class Model {
  /** `changed` is called after every change of the state. */
  constructor(content, engines, changed) {
    Object.assign(this, { content, engines, changed });
    this.score = new Function("v", `return ${content.score}`);
    this.uncompensated = new Function("v", `return ${content.uncompensated}`);
    const { stop, duty } = content;
    this.measured = null;
    this.start = { laws: Object.keys(content.laws), stop, repeat: duty.repeat, segments: duty.segments, values: {} };
    this.state = this.start;
  }

  set(part) {
    this.state = { ...this.state, ...part };
    this.changed();
  }

  setSegments(segments) {
    if (segments.length <= this.content.duty.most) this.set({ segments });
  }

  /** Change a parameter; null takes it back to the scenario's value. */
  setValue(name, value) {
    const { [name]: _, ...others } = this.state.values;
    this.set({ values: value === null ? others : { ...others, [name]: value } });
  }

  /** Give a thermometer a fault that is felt: from a quarter of the run on, by 2 K, or 2 K/h. */
  setFault(instance, channel, kind) {
    const name = (what) => `${instance}.fault_${what}${channel}`;
    const usual = { [name("time")]: Math.round(this.state.stop / 4), [name("size")]: 2, [name("rate")]: 2 / 3600 };
    const others = Object.entries(this.state.values).filter(([key]) => ![...Object.keys(usual), name("kind")].includes(key));
    this.set({ values: { ...Object.fromEntries(others), ...(kind ? { ...usual, [name("kind")]: kind } : {}) } });
  }

  /** Pairs of value reference and value that a law's run starts with. */
  values(law, values = this.state.values) {
    const { references, values: given } = this.content.laws[law];
    const { segments, repeat } = this.state;
    const duty = this.content.duty.drivers.flatMap((driver, joint) => {
      const vector = (name, of) =>
        Array.from({ length: this.content.duty.most }, (_, i) => [references[`${driver}.${name}[1]`] + i, of(segments[Math.min(i, segments.length - 1)], i)]);
      const demands = DEMANDS.flatMap((name) => vector(`segment_${name}`, (segment) => segment[name][joint]));
      const lasting = vector("duration", ({ duration }, i) => (i < segments.length ? duration : 0));
      return [[references[`${driver}.repeat`], Number(repeat)], ...lasting, ...demands];
    });
    return [...given, ...duty, ...Object.entries(values).map(([name, value]) => [references[name], value])];
  }

  /** Time series of a law's run: an array for each watched variable by name. */
  run(law, values) {
    const { watched, step, laws } = this.content;
    const references = watched.map((name) => laws[law].references[name]);
    const start = this.values(law, values);
    drawUnseen(); // directly before the engine, which needs it
    const columns = this.engines[law].run(references, Math.round(this.state.stop / step), step, start);
    return Object.fromEntries(watched.map((name, i) => [name, columns[i]]));
  }

  /** An expression at every communication point, in m. */
  evaluate(expression, series) {
    const [first] = Object.values(series);
    return first.map((_, i) => expression((name) => series[name][i]));
  }
}
