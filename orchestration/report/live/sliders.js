// Sliders of the parameters, ranked by how much they move the score.

import { choice, element, field } from "./dom.js";
import { digits } from "./figures.js";

const STEPS = 1000;
const MOST = 8;

/** A parameter's value as it is shown, and back; six digits. */
export const shown = (parameter, value) => digits(parameter.factor * value + parameter.offset);
const inSi = (parameter, number) => (number - parameter.offset) / parameter.factor;

function place({ low, high, byFactors }, value) {
  const share = byFactors ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(STEPS * share);
}

function valueAt({ low, high, byFactors }, position) {
  const share = position / STEPS;
  return Number((byFactors ? low * (high / low) ** share : low + share * (high - low)).toPrecision(4));
}

/** One row: name, slider, number with its unit, and a way back. */
export function sliderRow(parameter, model) {
  const { name, about, unit } = parameter;
  const get = () => model.state.values[name] ?? parameter.value;
  const set = (value) => model.setValue(name, value);
  const slider = field(
    { type: "range", min: 0, max: STEPS, step: 1, "aria-label": `${name}: ${about}`, input: () => set(valueAt(parameter, slider.value)) },
    () => place(parameter, get()),
    () => {},
  );
  const text = () => `${shown(parameter, get())} ${unit === "1" ? "" : unit}`;
  slider.addEventListener("input", () => slider.setAttribute("aria-valuetext", text()));
  slider.setAttribute("aria-valuetext", text());
  const number = field({ "aria-label": `${name} [${unit}]` }, () => shown(parameter, get()), (value) => set(inSi(parameter, value)));
  const back = element("button", { type: "button", "aria-label": `${name}: back to the scenario's value`, click: () => model.setValue(name, null) }, "↺");
  return element("div", { class: "slider", title: about }, element("span", {}, name), slider, number, element("span", {}, unit === "1" ? "" : unit), back);
}

/** Parameters by the largest change of the score when each grows by a tenth. */
export async function ranked(parameters, scoreWith) {
  const base = scoreWith({});
  const effects = [];
  for (const parameter of parameters) {
    await new Promise((resolve) => setTimeout(resolve)); // what the reader does meanwhile comes first
    let effect = 0;
    try {
      const score = scoreWith({ [parameter.name]: 1.1 * parameter.value });
      score.forEach((each, i) => (effect = Math.max(effect, Math.abs(each - base[i]))));
    } catch {
      // Refused by the component, as a tip beyond the link's end: such a value has no effect to rank.
    }
    effects.push([effect, parameter]);
  }
  return effects.sort((a, b) => b[0] - a[0]).map(([, parameter]) => parameter);
}

/** Fill a place with the sliders of the first parameters and of those that were changed or looked for. */
export function showSliders(target, parameters, model) {
  const changed = parameters.filter(({ name }, i) => i >= MOST && name in model.state.values && !/\.fault_/.test(name));
  target.replaceChildren(...[...parameters.slice(0, MOST), ...changed].map((each) => sliderRow(each, model)));
}

/** The sensors' faults: one choice for each thermometer, and when and how much. */
export function showFaults(target, thermometers, model) {
  const kinds = [[0, "well"], [1, "stuck"], [2, "jump"], [3, "drift"], [4, "drops out"]];
  const rows = thermometers.map(({ instance, channel, label }) => {
    const name = (what) => `${instance}.fault_${what}${channel}`;
    const number = (what, start, unit, factor) =>
      field({ "aria-label": `${label}: ${what} of the fault [${unit}]` }, () => digits((model.state.values[name(what)] ?? 0) * factor),
        (value) => model.setValue(name(what), value / factor));
    return element("tr", {}, element("th", { scope: "row" }, label),
      element("td", {}, choice({ "aria-label": `${label}: fault` }, kinds, () => model.state.values[name("kind")] ?? 0,
        (kind) => model.setFault(instance, channel, Number(kind)))),
      element("td", {}, number("time", 0, "min", 1 / 60)), element("td", {}, number("size", 0, "K", 1)), element("td", {}, number("rate", 0, "K/h", 3600)));
  });
  target.replaceChildren(...rows);
}
