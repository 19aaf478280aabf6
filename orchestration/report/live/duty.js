// The duty cycle on a time axis: the top of a segment is dragged, and the line after it.

import { at, content, fields, put, tell, texts } from "./model.js";
import { draw } from "./plot.js";

const LEAST = 5; // highest value of the axis, at least

let [axes, drag] = [null, null];

/** Draw the segments with the demand that is chosen, and show their table's columns that belong to it. */
export function drawDuty() {
  const { value: name, selectedOptions: [{ text: label }] } = at("dragged");
  const [shown, [duration]] = [texts(), content.words.duration];
  const [durations, values] = [duration, name].map((each) => shown[each].split(",").map(Number));
  const ends = durations.map((_, i) => durations.slice(0, i + 1).reduce((sum, each) => sum + each));
  const stop = shown[content.repeat] === "1" ? ends.at(-1) : Math.max(ends.at(-1), shown.stop);
  if (!drag) axes = { label, stop, low: 0, high: Math.max(LEAST, 1.2 * Math.max(...values)) }; // else the scale is kept
  const bars = values.map((value, i) => {
    const [begin, end] = [ends[i - 1] ?? 0, ends[i]];
    const [top, side] = [`d="M${begin} ${value}H${end}"`, `d="M${end} 0V${axes.high}"`];
    return `<path class="bar" d="M${begin} 0V${value}H${end}V0Z"/><path class="edge" ${side}/><path class="top" ${top}/>
      <path class="handle" data-along="y" data-name="${name}" data-segment="${i}" ${top}/>
      <path class="handle side" data-along="x" data-name="${duration}" data-segment="${i}" ${side}/>`;
  });
  draw(at("duty"), { ...axes, told: `${label} over time: ${values.length} segments, which the table below lists` }, bars);
  for (const cell of document.querySelectorAll("[data-joint]")) cell.hidden = !name.startsWith(cell.dataset.joint);
}

/** Put so many copies in a segment's place, which share its time: none removes it, two split it. */
export function copies(segment, count) {
  const left = at("segments").rows.length + count - 1;
  if (left < 1 || left > content.most) return;
  const shown = texts();
  const names = Object.values(content.words).flat();
  put(Object.fromEntries(names.map((name, k) => {
    const values = shown[name].split(",");
    const copy = k ? values[segment] : values[segment] / count;
    return [name, values.toSpliced(segment, 1, ...Array(count).fill(copy)).join()];
  })));
}

/** Where the pointer is, in s and in the unit of what is shown. */
const place = ({ clientX, clientY }) =>
  new DOMPoint(clientX, clientY).matrixTransform(at("duty").querySelector("g").getScreenCTM().inverse());

at("duty").addEventListener("pointerdown", (event) => {
  const { name, segment, along } = event.target.dataset;
  if (!name) return;
  at("duty").setPointerCapture(event.pointerId);
  const field = fields(name)[segment];
  drag = { field, along, offset: field.value - place(event)[along] };
});

at("duty").addEventListener("pointermove", (event) => {
  if (!drag) return;
  const value = drag.offset + place(event)[drag.along];
  drag.field.value = Math.max(drag.field.min, drag.along === "x" ? 10 * Math.round(value / 10) : value.toFixed(2));
  tell();
});

at("duty").addEventListener("pointerup", () => { drag = null; tell(); });
