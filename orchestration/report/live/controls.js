// What is dragged: the duty cycle on a time axis, and sliders of parameters.

import { digits, draw, escaped } from "./figures.js";
import { at, changed, content, fields, laws, put, quantity, run, tell, texts } from "./model.js";

const LEAST = 5; // highest value of the duty's axis, at least
const SNAP = 10; // s to which a dragged segment's duration is rounded; none is dragged to be shorter
const SHOWN = 8; // sliders that are shown, unless more were moved
const MOST_RANKED = 1e6; // communication points that all the runs of a ranking may have

const figure = at("duty");

let axes; // of the duty; they stay as they are while something is dragged

let ranked = []; // rows of sliders, once they are ranked

/** Draw the segments with the demand that is chosen, and show their table's columns that belong to it. */
export function drawDuty() {
  if (!content.words.duration) return;
  const { value: name, selectedOptions: [{ text: label }] } = at("dragged");
  const [shown, [duration]] = [texts(), content.words.duration];
  const [durations, values] = [duration, name].map((each) => shown[each].split(",").map(Number));
  const ends = durations.map((_, i) => durations.slice(0, i + 1).reduce((sum, each) => sum + each));
  const stop = shown[content.repeat] === "1" ? ends.at(-1) : Math.max(ends.at(-1), shown.stop);
  if (!figure.onpointermove) axes = { label, stop, low: 0, high: Math.max(LEAST, 1.2 * Math.max(...values)) };
  const bars = values.map((value, i) => {
    const [begin, end] = [ends[i - 1] ?? 0, ends[i]];
    return `<path class="bar" d="M${begin} 0V${value}H${end}V0Z"/>
      <path class="handle" cursor="ns-resize" data-along="y" data-name="${escaped(name)}" data-row="${i}" d="M${begin} ${value}H${end}"/>
      <path class="handle" cursor="ew-resize" data-along="x" data-name="${escaped(duration)}" data-row="${i}" d="M${end} 0V${axes.high}"/>`;
  });
  draw(figure, { ...axes, told: `${label} over time: ${values.length} segments, which the table below lists` }, bars);
  for (const cell of document.querySelectorAll("[data-joint]")) cell.hidden = !name.startsWith(cell.dataset.joint);
}

/** Where the pointer is, in s and in the unit of what is shown. */
const place = ({ clientX, clientY }) =>
  new DOMPoint(clientX, clientY).matrixTransform(figure.querySelector("g").getScreenCTM().inverse());

figure.onpointerdown = (event) => {
  const { name, row, along } = event.target.dataset;
  if (!name) return;
  figure.setPointerCapture(event.pointerId);
  const field = fields(name)[row];
  const offset = field.value - place(event)[along];
  figure.onpointermove = (moved) => {
    const value = offset + place(moved)[along];
    field.value = Math.max(field.min, along === "x" ? Math.max(SNAP, SNAP * Math.round(value / SNAP)) : value.toFixed(2));
    tell();
  };
};

figure.onpointerup = () => {
  figure.onpointermove = null;
  tell();
};

/** Put so many copies in a segment's place, which share its time: none removes it, two split it. */
export function copies(segment, count) {
  const left = at("segments").rows.length + count - 1;
  if (left < 1 || left > content.most) return;
  const [shown, [duration, ...others]] = [texts(), Object.values(content.words).flat()];
  for (const name of [duration, ...others]) {
    const values = shown[name].split(",");
    const copy = name === duration ? values[segment] / count : values[segment];
    shown[name] = values.toSpliced(segment, 1, ...Array(count).fill(copy)).join();
  }
  put(shown);
}

/** Set the number of a slider that was dragged. */
export function slid({ value, dataset, nextElementSibling }) {
  nextElementSibling.value = digits("powers" in dataset ? Math.exp(value) : Number(value), 4);
  tell();
}

/** Show the first sliders and those that were moved, or what is searched, where their numbers are. */
export function showSliders() {
  const [sought, moved] = [at("search").value, changed()];
  ranked.forEach((row, i) => {
    row.hidden = sought ? !`${row.textContent} ${row.title}`.includes(sought) : i >= SHOWN && !(row.id in moved);
    if (row.hidden) return;
    const [slider, { name, value }] = row.querySelectorAll("input, select");
    slider.value = "powers" in slider.dataset ? Math.log(value) : value;
    slider.ariaValueText = quantity(name, value);
  });
}

/** Rank the sliders by how much the score changes where a parameter grows by a tenth; not if trying all would last. */
export async function rank() {
  const [rows, effects, shown] = [[...at("sliders").children], {}, texts()];
  const score = (more) => run(laws()[0], { ...shown, ...more })(content.score);
  const tried = rows.filter((row) => row.querySelector("[data-powers]") && !row.id.includes("["));
  const base = score({});
  for (const { id } of (tried.length * shown.stop) / content.step > MOST_RANKED ? [] : tried) {
    await new Promise((resolve) => setTimeout(resolve)); // what the reader does meanwhile comes first
    try {
      const grown = score({ [id]: `${1.1 * shown[id]}` });
      effects[id] = grown.reduce((most, each, i) => Math.max(most, Math.abs(each - base[i])), 0);
    } catch {
      // The component refuses it, as a tip beyond the link's end.
    }
  }
  ranked = rows.sort((a, b) => (effects[b.id] ?? -1) - (effects[a.id] ?? -1));
  at("sliders").replaceChildren(...ranked);
  showSliders();
}
