// The page: it runs the system whenever something changes, and shows what comes of it.

import { element, field, refresh } from "./dom.js";
import { DutyEditor } from "./duty.js";
import { Engine } from "./engine.js";
import { duration, errorFigures, removed, since } from "./figures.js";
import { Model } from "./model.js";
import { drawPlot } from "./plot.js";
import { ranked, showFaults, showSliders } from "./sliders.js";

const UNCOMPENSATED = "none";
const RANKING_TIME = 4; // s
const at = (id) => document.getElementById(id);

async function unpacked(id) {
  const bytes = Uint8Array.from(atob(at(id).textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Run the chosen laws; the lines and the figures of the error. */
function results(model) {
  const { content, state } = model;
  const runs = Object.fromEntries(state.laws.map((law) => [law, model.run(law)]));
  const first = runs[state.laws[0]];
  const errors = { [UNCOMPENSATED]: model.evaluate(model.uncompensated, first) };
  for (const law of state.laws) if (law !== UNCOMPENSATED) errors[law] = model.evaluate(model.score, runs[law]);
  const figures = Object.entries(errors).map(([law, error]) => [law, errorFigures(error, content.step, content.tolerance)]);
  return { runs, errors, figures };
}

function showAnswer({ content }, figures) {
  const tolerance = `±${Number((1e6 * content.tolerance).toPrecision(6))} µm`;
  const micrometres = (key) => ([, of]) => `${of[key].toFixed(1)} µm`;
  const share = ([law, of]) => {
    const percent = law === UNCOMPENSATED ? null : removed(figures[0][1], of);
    return percent === null ? "" : `${Math.abs(percent).toFixed(0)} % ${percent < 0 ? "worse" : "removed"}`;
  };
  const rows = [
    ["largest error", micrometres("largest")],
    ["of the largest error", share],
    ["95 % of the time below", micrometres("p95")],
    ["root mean square", micrometres("rms")],
    [`within ${tolerance} from`, ([, of]) => since(of.within)],
  ];
  const cells = (tag, texts) => texts.map((text) => element(tag, { scope: tag === "th" ? "col" : null }, text));
  at("answer").replaceChildren(
    element("thead", {}, element("tr", {}, ...cells("th", ["", ...figures.map(([law]) => law)]))),
    element("tbody", {}, ...rows.map(([name, of]) => element("tr", {}, element("th", { scope: "row" }, name), ...cells("td", figures.map(of))))),
  );
  const told = figures.map(([law, of]) => `${law} ${of.largest.toFixed(1)} µm`);
  at("lead").textContent = `Largest error of the tool point: ${told.join(", ")}.`;
}

function showPlots(model, { runs, errors }) {
  const { content, state } = model;
  const styles = Object.fromEntries([UNCOMPENSATED, ...Object.keys(content.laws).filter((law) => law !== UNCOMPENSATED)].map((law, i) => [law, i]));
  const lines = Object.entries(errors).map(([law, error]) => ({ name: law, values: error.map((each) => 1e6 * each), style: styles[law] }));
  drawPlot(at("error"), { heading: "Error of the tool point", label: "error [µm]", step: content.step, lines, band: 1e6 * content.tolerance });
  content.plots.forEach((plot, number) => {
    const scaled = (values) => values.map((each) => plot.factor * (each - plot.zero));
    const drawn = Object.entries(plot.lines).flatMap(([name, variable]) => {
      const ofLaw = content.controllers.some((instance) => variable.startsWith(`${instance}.`));
      const laws = ofLaw ? state.laws.filter((law) => law !== UNCOMPENSATED) : state.laws.slice(0, 1);
      return laws.map((law) => ({ name: ofLaw ? `${name}, ${law}` : name, values: scaled(runs[law][variable]) }));
    });
    drawPlot(at(`plot-${number}`), { ...plot, step: content.step, lines: drawn.map((line, i) => ({ ...line, style: i % 6 })) });
  });
}

function show(model, editor) {
  const begun = performance.now();
  try {
    const found = results(model);
    showAnswer(model, found.figures);
    showPlots(model, found);
    at("fault").textContent = "";
  } catch (fault) {
    at("fault").textContent = `${fault.message}.`;
  }
  editor.show();
  refresh();
  at("time").textContent = `computed and drawn in ${(performance.now() - begun).toFixed(0)} ms`;
}

/** Sliders in the order of their effect, where all can be tried in a few seconds. */
function rankSliders(model) {
  const { parameters, important } = model.content;
  const tried = parameters.filter(({ name, value, unit }) => value && unit !== "degC" && !name.includes("["));
  const law = model.state.laws[0];
  const scoreWith = (values) => model.evaluate(model.score, model.run(law, { ...model.state.values, ...values }));
  const known = [...important, ...parameters.map(({ name }) => name)];
  const declared = [...new Set(known)].map((name) => parameters.find((each) => each.name === name));
  const effective = ranked(tried, scoreWith, RANKING_TIME);
  return effective ? [...effective, ...declared.filter((each) => !effective.includes(each))] : declared;
}

async function begin() {
  const content = JSON.parse(at("content").textContent);
  const modules = Object.keys(content.laws).map(async (law) => [law, await Engine.of(await unpacked(`module-${law}`))]);
  const engines = Object.fromEntries(await Promise.all(modules));
  let waiting = false;
  const model = new Model(content, engines, () => {
    if (!waiting) setTimeout(() => { waiting = false; show(model, editor); });
    waiting = true;
  });
  const editor = new DutyEditor(at("duty"), model, content.duty.drivers);
  const laws = Object.keys(content.laws).map((law) =>
    element("label", {}, element("input", { type: "checkbox", checked: true, change: ({ target }) => {
      const chosen = Object.keys(content.laws).filter((each) => (each === law ? target.checked : model.state.laws.includes(each)));
      if (chosen.length) model.set({ laws: chosen });
      else target.checked = true;
    } }), law));
  at("laws").append(...laws);
  at("stop").append(field({ min: 1, max: 24, "aria-label": "stop time [h]" }, () => model.state.stop / 3600, (hours) => model.set({ stop: 3600 * hours })), " h");
  at("repeat").append(element("input", { type: "checkbox", checked: content.duty.repeat, change: ({ target }) => model.set({ repeat: target.checked }) }), "begin again after the last");
  showFaults(at("faults"), content.thermometers, model);
  show(model, editor);
  addEventListener("resize", () => model.changed());
  const parameters = rankSliders(model);
  showSliders(at("sliders"), parameters, model);
  at("names").append(...parameters.map(({ name, about }) => element("option", { value: name }, about)));
  at("search").addEventListener("change", ({ target }) => {
    const found = parameters.findIndex(({ name }) => name === target.value);
    if (found < 0) return;
    parameters.unshift(...parameters.splice(found, 1));
    showSliders(at("sliders"), parameters, model);
    target.value = "";
  });
  return model;
}

begin();
