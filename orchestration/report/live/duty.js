// The duty cycle on a time axis: the top of a segment is dragged, and the line after it.

import { draw } from "./plot.js";

const SHORTEST = 10; // s
const LEAST = { speed: 5, torque: 4 }; // highest value of an axis, at least

/** Let segments be dragged in a figure; returns what draws them, with the demand that is chosen. */
export function dutyAxis(figure, choice, model) {
  let [axes, drag] = [null, null];

  /** Where the pointer is, in s and in the unit of what is shown. */
  const place = ({ clientX, clientY }) =>
    new DOMPoint(clientX, clientY).matrixTransform(figure.querySelector("g").getScreenCTM().inverse());

  figure.addEventListener("pointerdown", (event) => {
    const { name, along } = event.target.dataset;
    if (!name) return;
    figure.setPointerCapture(event.pointerId);
    drag = { name, along, offset: model.get(name) - place(event)[along] };
  });
  figure.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const value = drag.offset + place(event)[drag.along];
    const kept = drag.along === "x" ? Math.max(SHORTEST, 10 * Math.round(value / 10)) : Math.max(0, Number(value.toFixed(2)));
    model.set({ [drag.name]: kept });
  });
  figure.addEventListener("pointerup", () => { drag = null; model.onchange(); });

  return () => {
    const { segments, vectors, content } = model;
    const chosen = vectors.findIndex(({ name }) => name === choice.value);
    const { name, word, driver } = vectors[chosen];
    for (const cell of document.querySelectorAll("[data-driver]")) cell.hidden = cell.dataset.driver !== driver;
    document.querySelectorAll("[data-segment]").forEach((row, i) => { row.hidden = i >= segments.length; });
    const ends = segments.map((_, i) => segments.slice(0, i + 1).reduce((sum, [duration]) => sum + Number(duration), 0));
    const stop = model.get(`${content.drivers[0]}.repeat`) ? ends.at(-1) : Math.max(ends.at(-1), model.get("stop"));
    const high = Math.max(LEAST[word], 1.2 * Math.max(...segments.map((segment) => segment[chosen])));
    if (!drag) axes = { label: choice.selectedOptions[0].text, stop, low: 0, high }; // what is dragged keeps its scale
    const bars = segments.map((segment, i) => {
      const [begin, end, value] = [ends[i - 1] ?? 0, ends[i], segment[chosen]];
      const [top, side] = [`d="M${begin} ${value}H${end}"`, `d="M${end} 0V${axes.high}"`];
      return `<path class="bar" d="M${begin} 0V${value}H${end}V0Z"/><path class="edge" ${side}/><path class="top" ${top}/>
        <path class="handle" data-along="y" data-name="${name}[${i + 1}]" ${top}/>
        <path class="handle side" data-along="x" data-name="${vectors[0].name}[${i + 1}]" ${side}/>`;
    });
    draw(figure, axes, `${axes.label} over time: ${segments.length} segments, which the table below lists`, bars);
  };
}
