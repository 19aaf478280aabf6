// A component compiled for the browser (fmus/packaging/native/sources/browser.c), and runs of it.

/** The bytes of what is compressed, in base 64. */
async function unpacked(packed) {
  const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

/**
 * What runs a component, from its module, which imports nothing, with the tables that it plays: compressed, in base 64.
 *
 * A run starts anew with `values`, pairs of value reference and start value. It gives an array for each value reference
 * in `watched`, with a number for each communication point, and throws an Error with the component's sentence where that
 * refuses something. Its `play` puts another table in a table's place.
 */
export async function engine(packed, tables = []) {
  const { instance } = await WebAssembly.instantiate(await unpacked(packed));
  const { _initialize, reset, set, initialize, get, step, fault, room, take, memory } = instance.exports;
  _initialize();

  const text = (place) => new TextDecoder().decode(new Uint8Array(memory.buffer, place)).split("\0")[0];

  function check(well) {
    if (!well) throw new Error(text(fault()));
  }

  /** Have the table of a number replaced by the bytes of another one's file. */
  function play(i, bytes) {
    const place = room(i, bytes.length);
    if (!place) throw new Error("there is no memory for the recorded duty; take a shorter one");
    new Uint8Array(memory.buffer, place).set(bytes);
    const wrong = text(take(i, bytes.length));
    if (wrong) throw new Error(`the table of the recorded duty ${wrong}`);
  }

  for (const [i, table] of tables.entries()) play(i, new Uint8Array(await unpacked(table)));

  const run = (watched, steps, size, values) => {
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
  return Object.assign(run, { play });
}
