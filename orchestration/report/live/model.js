// The form is the state of the page. Each field is named after a variable, and shows it in a unit of its own; the fields in
// a column of the duty's table share a name, and what they show is one text with commas.

export const at = (id) => document.getElementById(id);
export const content = JSON.parse(at("content").textContent);
export const engines = {}; // what runs the system, by law
export const measured = { rows: [] }; // a measured run: its file's name, and its rows

const form = at("form");
const [duration] = content.words.duration;
const [rows, row] = [at("segments").innerHTML, at("segments").rows[0].outerHTML];
const unseen = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
unseen.fillStyle = "#0008";
const expressions = ["score", "uncompensated"].map((name) => [name, new Function("v", `return ${content[name]}`)]);

/** The fields with a name. */
export const fields = (name) => form.querySelectorAll(`[name="${CSS.escape(name)}"]`);

/** What the fields show, by name. */
export function texts() {
  const shown = {};
  for (const [name, text] of new FormData(form)) shown[name] = name in shown ? `${shown[name]},${text}` : text;
  return shown;
}

export const start = texts();

/** What the fields show that were changed: of a kind ("parameter", "duty" or "page") or of all. */
export function changed(kind) {
  const all = Object.entries(texts()).filter(([name, text]) => text !== start[name]);
  return Object.fromEntries(all.filter(([name]) => !kind || fields(name)[0].dataset.kind === kind));
}

/** A text with its unit. */
export function quantity(name, text) {
  const { unit } = fields(name)[0].dataset;
  return unit === "1" ? text : `${text} ${unit}`;
}

/** A text's value in the SI unit. */
export function inSi(name, text) {
  const { factor, offset } = fields(name)[0].dataset;
  return (text - offset) / factor;
}

/** Let whoever follows the form know that it changed. */
export const tell = () => form.dispatchEvent(new Event("change"));

/** The HTML of a segment's row: the first one's with another number in its heading and labels. */
const rowOf = (number) => row.replaceAll(/(?<=<th scope="row">|segment )1/g, number);

/** Show texts; those of the duration say how many segments there are. */
export function put(given) {
  const table = at("segments");
  const count = Math.min(given[duration]?.split(",").length ?? table.rows.length, content.most);
  while (table.rows.length > count) table.deleteRow(-1);
  while (table.rows.length < count) table.insertAdjacentHTML("beforeend", rowOf(table.rows.length + 1));
  for (const [name, text] of Object.entries(given)) {
    const each = text.split(",");
    fields(name).forEach((field, i) => {
      if (field.type === "checkbox") field.checked = each.includes(field.value);
      else field.value = each[i];
    });
  }
  tell();
}

/** Show what the page began with. */
export function reset() {
  at("segments").innerHTML = rows;
  form.reset();
  tell();
}

/** Values of a law's run: of the watched variables, and both errors in m, `score` and `uncompensated`. */
export function run(law, shown = texts()) {
  const { watched, step, laws } = content;
  const { references, values } = laws[law];
  const set = Object.entries(shown).filter(([name, text]) => name in references && text !== start[name]);
  const more = set.flatMap(([name, text]) => {
    const each = text.split(",").map((one) => inSi(name, one));
    const unused = name === duration ? 0 : each[0]; // in segments beyond those of the table
    const places = Object.entries(references[name]);
    return places.flatMap(([place, all]) => all.map((reference) => [reference, each[place] ?? unused]));
  });
  // In Firefox 140 a search in a text or an array leaves the registers of some processors (those with AVX-512) so that
  // WebAssembly runs a hundred times slower, until something translucent is drawn.
  unseen.fillRect(0, 0, 8, 8);
  unseen.getImageData(0, 0, 1, 1);
  const wanted = watched.map((name) => references[name][0][0]);
  const columns = engines[law](wanted, Math.round(shown.stop / step), step, [...values, ...more]);
  const found = Object.fromEntries(watched.map((name, i) => [name, columns[i]]));
  const evaluated = expressions.map(([name, at]) => [name, columns[0].map((_, i) => at((each) => found[each][i]))]);
  return { ...found, ...Object.fromEntries(evaluated) };
}
