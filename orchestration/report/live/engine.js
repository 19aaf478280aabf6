// A component compiled for the browser (fmus/packaging/native/sources/browser.c), and runs of it.

/**
 * What runs a component, from the bytes of its module, which imports nothing.
 *
 * A run starts anew with `values`, pairs of value reference and start value. It gives an array for each value reference
 * in `watched`, with a number for each communication point, and throws an Error with the component's sentence where that
 * refuses something.
 */
export async function engine(bytes) {
  const { reset, set, initialize, room, run, fault, memory, _initialize } = (await WebAssembly.instantiate(bytes)).instance.exports;
  _initialize();

  function check(well) {
    if (well) return;
    const text = new Uint8Array(memory.buffer, fault());
    throw new Error(new TextDecoder().decode(text.subarray(0, text.indexOf(0))));
  }

  return (watched, steps, step, values) => {
    reset();
    for (const [reference, value] of values) check(set(reference, value));
    check(initialize());
    const [points, width] = [steps + 1, watched.length];
    const place = room((8 * points + 4) * width);
    const references = place + 8 * points * width;
    new Uint32Array(memory.buffer, references, width).set(watched);
    check(run(steps, step, references, width, place));
    const found = new Float64Array(memory.buffer, place, points * width);
    return watched.map((_, i) => found.slice(points * i, points * (i + 1)));
  };
}
