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
   * `values` are pairs of value reference and start value. Throws an Error with the component's sentence where it refuses
   * something.
   */
  run(watched, steps, step, values) {
    const { exports } = this;
    exports.reset();
    for (const [reference, value] of values) this.check(exports.set(reference, value));
    this.check(exports.initialize());
    const width = watched.length;
    const size = width * (steps + 1);
    const place = exports.room(8 * size + 4 * width);
    const references = place + 8 * size;
    new Uint32Array(exports.memory.buffer, references, width).set(watched);
    this.check(exports.run(steps, step, references, width, place));
    const rows = new Float64Array(exports.memory.buffer, place, size);
    return watched.map((_, column) => {
      const found = new Float64Array(steps + 1);
      for (let row = 0; row <= steps; row++) found[row] = rows[row * width + column];
      return found;
    });
  }

  check(well) {
    if (well) return;
    const memory = new Uint8Array(this.exports.memory.buffer);
    const start = this.exports.fault();
    throw new Error(new TextDecoder().decode(memory.slice(start, memory.indexOf(0, start))));
  }
}
