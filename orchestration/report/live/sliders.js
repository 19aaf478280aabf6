// Sliders of parameters, each before the number that it moves; those that move the score most come first.

import { digits } from "./figures.js";
import { at, changed, content, fields, quantity, run, tell, texts } from "./model.js";

const SHOWN = 8;
const MOST_RANKED = 1e6; // communication points that all the runs of a ranking may have

let ranked = []; // of sliders, once they are ranked

/** Set the number of a slider that was dragged. */
export function slid({ value, dataset, nextElementSibling }) {
  nextElementSibling.value = digits("powers" in dataset ? Math.exp(value) : Number(value), 4);
  tell();
}

/** Show the first sliders and those that were moved, or what is searched, where their numbers are. */
export function showSliders() {
  const [sought, moved] = [at("search").value, changed("parameter")];
  ranked.forEach((row, i) => {
    row.hidden = sought ? !`${row.textContent} ${row.title}`.includes(sought) : i >= SHOWN && !(row.id in moved);
    if (row.hidden) return;
    const [slider, { name, value }] = row.querySelectorAll("input, select");
    slider.value = "powers" in slider.dataset ? Math.log(value) : value;
    slider.setAttribute("aria-valuetext", quantity(name, value));
  });
}

/** Rank the sliders by how much the score changes where a parameter grows by a tenth; not if trying all would last. */
export async function rank() {
  const [found, effects, shown] = [[...at("sliders").children], {}, texts()];
  const ofScore = (more) => run(shown.law.split(",")[0], { ...shown, ...more }).score;
  const all = found.map(({ id }) => fields(id)[0]);
  const tried = all.filter(({ name, value, dataset }) => Number(value) && dataset.unit !== "degC" && !name.includes("["));
  if ((tried.length * shown.stop) / content.step <= MOST_RANKED) {
    const base = ofScore({});
    for (const { name, value } of tried) {
      await new Promise((resolve) => setTimeout(resolve)); // what the reader does meanwhile comes first
      try {
        const changes = ofScore({ [name]: `${1.1 * value}` }).map((each, i) => Math.abs(each - base[i]));
        effects[name] = changes.reduce((most, each) => Math.max(most, each));
      } catch {
        effects[name] = 0; // refused by the component, as a tip beyond the link's end
      }
    }
  }
  ranked = found.sort((a, b) => (effects[b.id] ?? -1) - (effects[a.id] ?? -1));
  at("sliders").replaceChildren(...ranked);
  showSliders();
}
