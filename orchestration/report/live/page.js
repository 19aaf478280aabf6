// The page: it runs the system whenever something changes, and shows what comes of it.

import { element, field, refresh } from "./dom.js";
import { DutyEditor } from "./duty.js";
import { Engine } from "./engine.js";
import { duration, errorFigures, removed, since } from "./figures.js";
import { Model } from "./model.js";
import { measuredSegments, readMeasured } from "./measured.js";
import { drawPlot } from "./plot.js";
import { address, command, diagnosis, needsFile, parameterSet, restored, scenarioFile, scenarioText } from "./share.js";
import { ranked, showFaults, showSliders } from "./sliders.js";

const UNCOMPENSATED = "none";
const MOST_RANKED = 1e6; // communication points that all the runs of a ranking may have
const MOST_MARKS = 150;
const ADDRESS_AFTER = 400; // ms without a change; browsers refuse an address that changes a hundred times in half a minute
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

function showAnswer({ content, state }, figures) {
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
    element("thead", {}, element("tr", {}, ...cells("th", ["figure", ...figures.map(([law]) => law)]))),
    element("tbody", {}, ...rows.map(([name, of]) => element("tr", {}, element("th", { scope: "row" }, name), ...cells("td", figures.map(of))))),
  );
  const notes = Object.entries(content.notes).filter(([law, note]) => note && state.laws.includes(law));
  at("notes").textContent = Object.keys(state.values).length ? "" : notes.map(([law, note]) => `${law}: ${note}.`).join(" ");
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
      const marks = marked(model, variable).map(([time, value]) => [time, plot.factor * (value - plot.zero)]);
      return laws.map((law) => ({ name: ofLaw ? `${name}, ${law}` : name, values: scaled(runs[law][variable]), marks }));
    });
    drawPlot(at(`plot-${number}`), { ...plot, step: content.step, lines: drawn.map((line, i) => ({ ...line, style: i % 6 })) });
  });
}

/** Times and values of a measured variable within the run; of very many, every so manieth. */
function marked({ measured, content, state }, variable) {
  const name = Object.keys(measured?.series ?? {}).find((each) => content.columns[each].variable === variable);
  if (!name) return [];
  const found = measured.times.map((time, i) => [time, measured.series[name][i]]);
  const every = Math.ceil(found.length / MOST_MARKS);
  return found.filter(([time, value], i) => i % every === 0 && time <= state.stop && Number.isFinite(value));
}

/** Take a measured run: its duty where it holds one, and its readings over the lines. */
async function take(model, file) {
  const { content, start } = model;
  const measured = readMeasured(await file.text(), content.columns, file.name);
  const stop = content.step * Math.floor(measured.times.at(-1) / content.step);
  const segments = measuredSegments(measured, start.segments[0]);
  const driven = ["speed", "torque"].some((name) => name in measured.series);
  if (driven && content.duty.drivers.length > 1) throw new Error(`${file.name}: the page takes measured runs of a single axis only`);
  if (driven && segments.length > content.duty.most)
    throw new Error(`${file.name}: ${segments.length} segments are more than the ${content.duty.most} that the page takes; average the duty over longer times`);
  model.measured = { name: file.name, ...measured };
  model.set({ stop, ...(driven ? { segments, repeat: false } : {}) });
}

/** What computes the same elsewhere. */
function showCommands(model) {
  const { state, measured } = model;
  const wanted = [...state.laws.map((law) => command(model, law)), ...(measured ? [diagnosis(model, measured.name)] : [])];
  at("command").textContent = wanted.join("\n");
  at("scenario-note").hidden = !needsFile(model);
  at("scenario-note").textContent = `The command takes a file with what was changed: download ${scenarioFile(model)} first.`;
  clearTimeout(model.addressing);
  model.addressing = setTimeout(() => history.replaceState(null, "", address(model)), ADDRESS_AFTER);
}

function download(name, text) {
  const link = element("a", { href: URL.createObjectURL(new Blob([text])), download: name });
  link.click();
  URL.revokeObjectURL(link.href);
}

/** What a button or a dropped file does; what is refused is said in a sentence. */
async function attempt(action) {
  try {
    await action();
  } catch (fault) {
    at("fault").textContent = `${fault.message}.`;
  }
}

function shareAndDrop(model) {
  const { name } = model.content;
  const does = (id, action) => at(id).addEventListener("click", () => attempt(action));
  does("copy", () => navigator.clipboard.writeText(at("command").textContent));
  does("save-scenario", () => download(scenarioFile(model), scenarioText(model, model.state.laws[0])));
  does("save-parameters", () => download(`${name}_live.ssv`, parameterSet(model)));
  does("reset", () => model.set(model.start));
  at("csv").addEventListener("change", ({ target }) => target.files.length && attempt(() => take(model, target.files[0])));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length) attempt(() => take(model, event.dataTransfer.files[0]));
  });
}

function show(model, editor) {
  const begun = performance.now();
  try {
    const found = results(model);
    showAnswer(model, found.figures);
    showPlots(model, found);
    showCommands(model);
    at("fault").textContent = "";
  } catch (fault) {
    at("fault").textContent = `${fault.message}.`;
  }
  editor.show();
  refresh();
  at("time").textContent = `computed and drawn in ${(performance.now() - begun).toFixed(0)} ms`;
}

/** Parameters in the order of their effect, where all can be tried in a few seconds; else the known ones first. */
async function sorted(model) {
  const { content, state } = model;
  const { parameters } = content;
  const known = [...content.important, ...parameters.map(({ name }) => name)];
  const declared = [...new Set(known)].map((name) => parameters.find((each) => each.name === name));
  const tried = declared.filter(({ name, value, unit }) => value && unit !== "degC" && !name.includes("["));
  if ((tried.length * state.stop) / content.step > MOST_RANKED) return declared;
  const scoreWith = (values) => model.evaluate(model.score, model.run(state.laws[0], { ...state.values, ...values }));
  const effective = await ranked(tried, scoreWith);
  return [...new Set([...effective, ...declared])];
}

/** The sliders, once they are in order. */
async function listSliders(model) {
  const parameters = await sorted(model);
  showSliders(at("sliders"), parameters, model);
  at("names").append(...parameters.map(({ name, about }) => element("option", { value: name }, about)));
  at("search").addEventListener("change", ({ target }) => {
    const found = parameters.findIndex(({ name }) => name === target.value);
    if (found < 0) return;
    parameters.unshift(...parameters.splice(found, 1));
    showSliders(at("sliders"), parameters, model);
    target.value = "";
  });
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
  await attempt(() => { model.state = restored(location.hash, model); });
  const refused = at("fault").textContent;
  const editor = new DutyEditor(at("duty"), model, content.duty.drivers);
  const laws = Object.keys(content.laws).map((law) =>
    element("label", {}, element("input", { type: "checkbox", checked: model.state.laws.includes(law), change: ({ target }) => {
      const chosen = Object.keys(content.laws).filter((each) => (each === law ? target.checked : model.state.laws.includes(each)));
      if (chosen.length) model.set({ laws: chosen });
      else target.checked = true;
    } }), law));
  at("laws").append(...laws);
  at("stop").append(field({ min: 1, max: 24, "aria-label": "stop time [h]" }, () => model.state.stop / 3600, (hours) => model.set({ stop: 3600 * hours })), " h");
  at("repeat").append(element("input", { type: "checkbox", checked: model.state.repeat, change: ({ target }) => model.set({ repeat: target.checked }) }), "begin again after the last");
  showFaults(at("faults"), content.thermometers, model);
  shareAndDrop(model);
  show(model, editor);
  if (refused) at("fault").textContent = refused;
  addEventListener("resize", () => model.changed());
  listSliders(model);
  return model;
}

begin();
