// Elements of the page, and fields that show a value until somebody types into them.

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") made.addEventListener(name, value);
    else if (value !== null && value !== false) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children);
  return made;
}

const fields = new Map();

/** An input that shows `get()`, and gives what is typed to `set`; an empty or wrong number is taken back. */
export function field(attributes, get, set) {
  const made = element("input", { type: "number", step: "any", ...attributes });
  made.addEventListener("change", () => {
    if (made.value !== "" && made.checkValidity()) set(Number(made.value));
    made.value = get();
  });
  fields.set(made, get);
  made.value = get();
  return made;
}

export function choice(attributes, options, get, set) {
  const listed = options.map(([value, text]) => element("option", { value }, text));
  const made = element("select", { ...attributes, change: () => set(made.value) }, ...listed);
  fields.set(made, get);
  made.value = get();
  return made;
}

/** Show the present values in all fields but the one that is being typed into. */
export function refresh() {
  for (const [made, get] of fields) {
    if (!made.isConnected) fields.delete(made);
    else if (made !== document.activeElement || made.type !== "number") made.value = get();
  }
}

const unseen = element("canvas", { width: 8, height: 8 }).getContext("2d", { willReadFrequently: true });
unseen.fillStyle = "#0008";

/**
 * Draw something translucent that nobody sees. In Firefox 140 a search in a text or an array leaves the registers of some
 * processors (those with AVX-512) so that WebAssembly runs a hundred times slower until this sets them right.
 */
export function drawUnseen() {
  unseen.fillRect(0, 0, 8, 8);
  unseen.getImageData(0, 0, 1, 1);
}
