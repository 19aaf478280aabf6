// A component compiled for the browser (fmus/packaging/native/sources/browser.c), and runs of it.

/**
 * What runs a component, from the bytes of its module, which imports nothing.
 *
 * A run starts anew with `values`, pairs of value reference and start value. It gives an array for each value reference
 * in `watched`, with a number for each communication point, and throws an Error with the component's sentence where that
 * refuses something.
 */
export async function engine(bytes) {
  const { _initialize, reset, set, initialize, get, step, fault, memory } = (await WebAssembly.instantiate(bytes)).instance.exports;
  _initialize();

  function check(well) {
    if (well) return;
    const text = new Uint8Array(memory.buffer, fault());
    throw new Error(new TextDecoder().decode(text.subarray(0, text.indexOf(0))));
  }

  return (watched, steps, size, values) => {
    reset();
    for (const [reference, value] of values) check(set(reference, value));
    check(initialize());
    const found = watched.map(() => new Float64Array(steps + 1));
    for (let i = 0; i <= steps; i++) {
      if (i) check(step((i - 1) * size, size));
      for (let k = 0; k < watched.length; k++) found[k][i] = get(watched[k]);
    }
    return found;
  };
}
