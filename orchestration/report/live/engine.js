// A component compiled for the browser (fmus/packaging/native/sources/browser.c), and runs of it.

/**
 * What runs a component, from its module, which imports nothing: compressed, in base 64.
 *
 * A run starts anew with `values`, pairs of value reference and start value. It gives an array for each value reference
 * in `watched`, with a number for each communication point, and throws an Error with the component's sentence where that
 * refuses something.
 */
export async function engine(packed) {
  const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
  const unpacked = new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")));
  const { instance } = await WebAssembly.instantiate(await unpacked.arrayBuffer());
  const { _initialize, reset, set, initialize, get, step, fault, memory } = instance.exports;
  _initialize();

  function check(well) {
    if (!well) throw new Error(new TextDecoder().decode(new Uint8Array(memory.buffer, fault())).split("\0")[0]);
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
