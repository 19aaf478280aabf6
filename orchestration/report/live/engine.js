// A component compiled for the browser (fmus/packaging/native/sources/browser.c), and runs of it.

export class Engine {
  /** Engine of a module's bytes, which imports nothing. */
  static async of(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    instance.exports._initialize();
    return new Engine(instance.exports);
  }

  constructor(exports) {
    this.exports = exports;
  }

  /**
   * Run from the start: an array for each value reference in `watched`, with one number for each communication point.
   *
   * `values` are pairs of value reference and start value; `changes` are [communication point, pairs], in order, which
   * are set during the run. Throws an Error with the component's sentence where it refuses something.
   */
  run(watched, steps, step, values, changes = []) {
    const { exports } = this;
    exports.reset();
    this.set(values);
    this.check(exports.initialize());
    const width = watched.length;
    const place = exports.room(8 * width * (steps + 1) + 4 * width);
    const references = place + 8 * width * (steps + 1);
    new Uint32Array(exports.memory.buffer, references, width).set(watched);
    let first = 0;
    for (const [point, pairs] of [...changes.filter(([at]) => at < steps), [steps, []]]) {
      const count = point - first;
      this.check(exports.run(first, count, step, references, width, place + 8 * width * first) === count);
      this.set(pairs);
      first = point;
    }
    const rows = new Float64Array(exports.memory.buffer, place, width * (steps + 1));
    return watched.map((_, column) => {
      const values = new Float64Array(steps + 1);
      for (let row = 0; row <= steps; row++) values[row] = rows[row * width + column];
      return values;
    });
  }

  set(pairs) {
    for (const [reference, value] of pairs) this.check(this.exports.set(reference, value));
  }

  check(well) {
    if (well) return;
    const memory = new Uint8Array(this.exports.memory.buffer);
    const start = this.exports.fault();
    throw new Error(new TextDecoder().decode(memory.slice(start, memory.indexOf(0, start))));
  }
}
