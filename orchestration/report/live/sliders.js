// Sliders of parameters, each before the number that it moves, ranked by how much they move the score.

import { digits } from "./figures.js";

const SHOWN = 8;
const MOST_RANKED = 1e6; // communication points that all the runs of a ranking may have

/** Set the number of a slider that was dragged. */
export function slid({ value, dataset, nextElementSibling }, model) {
  model.put({ [nextElementSibling.name]: digits("powers" in dataset ? Math.exp(value) : Number(value), 4) });
}

/** Put the sliders to where their numbers are. */
export function follow() {
  for (const slider of document.querySelectorAll(".slider:not([hidden]) [type=range]")) {
    const { value, dataset } = slider.nextElementSibling;
    slider.value = "powers" in slider.dataset ? Math.log(value) : value;
    slider.setAttribute("aria-valuetext", dataset.unit === "1" ? value : `${value} ${dataset.unit}`);
  }
}

/** Largest changes of the score when a parameter grows by a tenth, by its name; none where trying all would last. */
async function effects(parameters, model) {
  const tried = parameters.filter(({ name, value, dataset }) => Number(value) && dataset.unit !== "degC" && !name.includes("["));
  const score = (more) => model.evaluate(model.score, model.run(model.laws[0], more));
  const found = {};
  if ((tried.length * model.get("stop")) / model.content.step > MOST_RANKED) return found;
  const base = score({});
  for (const { name } of tried) {
    await new Promise((resolve) => setTimeout(resolve)); // what the reader does meanwhile comes first
    try {
      const changes = score({ [name]: 1.1 * model.get(name) }).map((each, i) => Math.abs(each - base[i]));
      found[name] = changes.reduce((most, each) => Math.max(most, each));
    } catch {
      found[name] = 0; // refused by the component, as a tip beyond the link's end
    }
  }
  return found;
}

/** Order the sliders in a place by their effect; show the first and those that were changed, or what is searched. */
export async function list(place, search, model) {
  const rows = [...place.querySelectorAll(".slider")];
  const found = await effects(rows.map(({ id }) => model.fields.get(id)), model);
  rows.sort((a, b) => (found[b.id] ?? -1) - (found[a.id] ?? -1));
  place.replaceChildren(...rows);
  const show = () => {
    const hidden = search.value
      ? ({ textContent, title }) => !`${textContent} ${title}`.includes(search.value)
      : ({ id }, i) => i >= SHOWN && !model.changed("parameter").includes(id);
    rows.forEach((row, i) => { row.hidden = hidden(row, i); });
    follow();
  };
  search.addEventListener("input", show);
  show();
}
