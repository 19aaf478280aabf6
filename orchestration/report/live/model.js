// The form is the state of the page. Each field is named after a variable, and shows it in a unit of its own; the fields in
// a column of the duty's table share a name, and what they show is one text with commas.

export const at = (id) => document.getElementById(id);
export const fields = (name) => document.getElementsByName(name);

/** What the page knows (content.py); an expression is a function of the values by variable, and of the step. */
export const content = JSON.parse(at("content").textContent, (key, value) =>
  typeof value === "string" && (key === "expression" || key === "score") ? new Function("v", "i", `return ${value}`) : value);

export const measured = { rows: [] }; // a measured run: its file's name, and its rows

const [form, table] = [at("form"), at("segments")];
const [duration] = content.words.duration ?? []; // none where the duty is recorded
const unseen = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
unseen.fillStyle = "#0008";

/** What the fields show, by name. */
export function texts() {
  const shown = {};
  for (const [name, text] of new FormData(form)) shown[name] = name in shown ? `${shown[name]},${text}` : text;
  return shown;
}

export const start = texts();

/** What the fields show that were changed, by name. */
export const changed = () => Object.fromEntries(Object.entries(texts()).filter(([name, text]) => text !== start[name]));

/** The laws that are chosen. */
export const laws = () => texts().law.split(",");

/** A text with its unit. */
export const quantity = (name, text) => `${text} ${fields(name)[0].dataset.unit}`.trim();

/** A text's value in the SI unit. */
export const inSi = (name, text) => (text - fields(name)[0].dataset.offset) / fields(name)[0].dataset.factor;

/** Let whoever follows the form know that it changed. */
export const tell = () => form.dispatchEvent(new Event("change"));

/** The HTML of a segment's row: the first one's with another number in its heading and labels. */
const rowOf = (number) => table.rows[0].outerHTML.replaceAll(/(?<=<th scope="row">|segment )1/g, number);

/** Show texts; those of the duration say how many segments there are. */
export function put(given) {
  const count = Math.min(given[duration]?.split(",").length ?? table.rows.length, content.most);
  while (table.rows.length > count) table.deleteRow(-1);
  while (table.rows.length < count) table.insertAdjacentHTML("beforeend", rowOf(table.rows.length + 1));
  for (const [name, text] of Object.entries(given)) {
    const each = text.split(",");
    fields(name).forEach((field, i) => {
      if (field.type === "checkbox") field.checked = each.includes(field.value);
      else if (field.dataset.kind) field.value = each[i]; // no button, no <meta>
    });
  }
  tell();
}

/** Run the system with a law. What comes of it is a function: from an expression to its value at every step. */
export function run(law, shown = texts()) {
  const { engine, references, values, watched } = content.laws[law];
  const set = Object.entries(shown).filter(([name, text]) => name in references && text !== start[name]);
  const more = set.flatMap(([name, text]) => {
    const each = text.split(",").map((one) => inSi(name, one));
    const unused = name === duration ? 0 : each[0]; // in segments beyond those of the table
    return references[name].flatMap((all, place) => all.map((reference) => [reference, each[place] ?? unused]));
  });
  // In Firefox 140 a search in a text or an array leaves the registers of some processors (those with AVX-512) so that
  // WebAssembly runs a hundred times slower, until something translucent is drawn.
  unseen.fillRect(0, 0, 8, 8);
  unseen.getImageData(0, 0, 1, 1);
  const columns = engine(watched, Math.round(shown.stop / content.step), content.step, [...values, ...more]);
  const found = Object.fromEntries(content.watched.map((name, k) => [name, columns[k]]));
  return (expression) => columns[0].map((_, i) => expression(found, i));
}
