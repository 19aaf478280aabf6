// The page: it runs the system whenever something changes, and shows what comes of it.

import { dutyAxis } from "./duty.js";
import { engine } from "./engine.js";
import { errorFigures, removed, since } from "./figures.js";
import { measuredSegments, readMeasured } from "./measured.js";
import { Model } from "./model.js";
import { drawLines } from "./plot.js";
import { address, commands, needsFile, parameterSet, restore, scenarioText } from "./share.js";
import { follow, list, slid } from "./sliders.js";

const UNCOMPENSATED = "none";
const MOST_MARKS = 150;
const ADDRESS_AFTER = 400; // ms without a change; browsers refuse an address that changes a hundred times in half a minute
const at = (id) => document.getElementById(id);

/** Run the chosen laws: their values, the errors by law, and the figures of these. */
function results(model) {
  const { step, tolerance } = model.content;
  const runs = Object.fromEntries(model.laws.map((law) => [law, model.run(law)]));
  const errors = { [UNCOMPENSATED]: model.evaluate(model.uncompensated, runs[model.laws[0]]) };
  for (const law of model.laws) if (law !== UNCOMPENSATED) errors[law] = model.evaluate(model.score, runs[law]);
  const figures = Object.entries(errors).map(([law, error]) => [law, errorFigures(error, step, tolerance)]);
  return { runs, errors, figures };
}

function showAnswer(model, figures) {
  const { tolerance, laws } = model.content;
  const micrometres = (value) => `${value.toFixed(1)} µm`;
  const rows = {
    figure: (of, law) => law,
    "largest error": (of) => micrometres(of.largest),
    "of the largest error": (of) => (of === figures[0][1] ? "" : removed(figures[0][1], of)),
    "95 % of the time below": (of) => micrometres(of.p95),
    "root mean square": (of) => micrometres(of.rms),
    [`within ±${Number((1e6 * tolerance).toPrecision(6))} µm from`]: (of) => since(of.within),
  };
  const lines = Object.entries(rows).map(([name, told]) => {
    const cells = figures.map(([law, of]) => `<td>${told(of, law)}</td>`);
    return `<tr><th scope="row">${name}</th>${cells.join("")}</tr>`;
  });
  at("answer").innerHTML = lines.join("");
  const noted = model.changed("parameter").length ? [] : model.laws.filter((law) => laws[law].note);
  at("notes").textContent = noted.map((law) => `${law}: ${laws[law].note}.`).join(" ");
  const largest = figures.map(([law, of]) => `${law} ${micrometres(of.largest)}`);
  at("lead").textContent = `Largest error of the tool point: ${largest.join(", ")}.`;
}

/** Times and values of a measured variable within the run; of very many, every so manieth. */
function marks({ measured, content }, variable, stop) {
  const name = Object.keys(measured?.series ?? {}).find((each) => content.columns[each].variable === variable);
  const found = name ? measured.times.map((time, i) => [time, measured.series[name][i]]) : [];
  const every = Math.ceil(found.length / MOST_MARKS);
  return found.filter(([time, value], i) => i % every === 0 && time <= stop && Number.isFinite(value));
}

function showPlots(model, { runs, errors }) {
  const { plots, step, tolerance, laws, controllers } = model.content;
  const compensated = model.laws.filter((law) => law !== UNCOMPENSATED);
  const styles = [...new Set([UNCOMPENSATED, ...Object.keys(laws)])];
  const lines = Object.entries(errors).map(([name, error]) => ({ name, values: error.map((each) => 1e6 * each), style: styles.indexOf(name) }));
  drawLines(at("plot-0"), { heading: "Error of the tool point", label: "error [µm]", lines, step, band: 1e6 * tolerance });
  plots.forEach((plot, number) => {
    const shown = (value) => plot.factor * (value - plot.zero);
    const drawn = Object.entries(plot.lines).flatMap(([name, variable]) => {
      const found = marks(model, variable, model.get("stop")).map(([time, value]) => [time, shown(value)]);
      const line = (law, title) => ({ name: title, values: runs[law][variable].map(shown), marks: found });
      const ofLaw = controllers.some((instance) => variable.startsWith(`${instance}.`));
      return ofLaw ? compensated.map((law) => line(law, `${name}, ${law}`)) : [line(model.laws[0], name)];
    });
    drawLines(at(`plot-${number + 1}`), { ...plot, step, lines: drawn });
  });
}

/** What computes the same elsewhere: commands, files, the address. */
function showCommands(model) {
  at("command").textContent = commands(model).join("\n");
  at("scenario-note").hidden = !needsFile(model);
  for (const [id, text] of Object.entries({ scenario: scenarioText(model), parameters: parameterSet(model) }))
    at(id).href = `data:text/plain;charset=utf-8,${encodeURIComponent(text)}`;
  clearTimeout(model.addressing);
  model.addressing = setTimeout(() => history.replaceState(null, "", address(model)), ADDRESS_AFTER);
}

/** Take a measured run: its duty where it holds one, and its readings over the lines. */
async function take(model, file) {
  const { columns, step, drivers, most } = model.content;
  const measured = readMeasured(await file.text(), columns, file.name);
  const refuse = (sentence) => { throw new Error(`${file.name}: ${sentence}`); };
  if ("speed" in measured.series || "torque" in measured.series) {
    if (drivers.length > 1) refuse("the page takes measured runs of a single axis only");
    const first = model.vectors.map(({ name, word }) => [word, model.get(`${name}[1]`, model.start.get(`${name}[1]`))]);
    const segments = measuredSegments(measured, Object.fromEntries(first));
    const many = `${segments.length} segments are more than the ${most} that the page takes`;
    if (segments.length > most) refuse(`${many}; average the duty over longer times`);
    model.segments = segments.map((segment) => model.vectors.map(({ name, word }) => model.shown(`${name}[1]`, segment[word])));
    model.set({ [`${drivers[0]}.repeat`]: 0 });
  }
  model.measured = { name: file.name, ...measured };
  model.set({ stop: step * Math.floor(measured.times.at(-1) / step) });
}

/** What buttons do, by their names, with their values. */
const actions = {
  copy: () => navigator.clipboard.writeText(at("command").textContent),
  back: (model, name) => model.put({ [name]: null }),
  remove(model, number) { model.segments = model.segments.toSpliced(number - 1, 1); },
  split(model, number) {
    const [duration, ...demands] = model.segments[number - 1];
    const half = [String(duration / 2), ...demands];
    model.segments = model.segments.toSpliced(number - 1, 1, half, half);
  },
};

/** Do what a button or a file asks for; what is refused is said in a sentence. */
async function attempt(action) {
  try {
    await action();
  } catch (fault) {
    at("fault").textContent = `${fault.message}.`;
  }
}

function show(model, showAxis) {
  const begun = performance.now();
  const unfelt = (field) => field.closest("tr").querySelector("select").value === "0";
  for (const field of document.querySelectorAll("#faults input")) field.disabled = unfelt(field);
  at("fault").textContent = "";
  attempt(() => {
    const found = results(model);
    showAnswer(model, found.figures);
    showPlots(model, found);
    showCommands(model);
  });
  showAxis();
  follow();
  at("time").textContent = `computed and drawn in ${(performance.now() - begun).toFixed(0)} ms`;
}

/** Follow what the reader types, drags, presses and drops. */
function listen(model) {
  const form = at("form");
  form.addEventListener("change", ({ target }) => {
    if (target.id === "dragged") model.onchange();
    if (!model.fields.has(target.name)) return;
    if (!target.validity.valid) model.put({ [target.name]: null });
    if (!model.laws.length) target.checked = true;
    model.segments = model.segments; // without those whose duration was emptied
  });
  form.addEventListener("input", ({ target }) => target.type === "range" && slid(target, model));
  form.addEventListener("reset", () => setTimeout(model.onchange));
  form.addEventListener("click", ({ target: { name, value } }) => name in actions && attempt(() => actions[name](model, value)));
  at("csv").addEventListener("change", ({ target: { files } }) => files.length && attempt(() => take(model, files[0])));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length) attempt(() => take(model, event.dataTransfer.files[0]));
  });
}

async function unpacked(id) {
  const bytes = Uint8Array.from(atob(at(id).textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function begin() {
  const content = JSON.parse(at("content").textContent);
  const engines = {};
  for (const law of Object.keys(content.laws)) engines[law] = await engine(await unpacked(`module-${law}`));
  let waiting = null;
  const changed = () => { waiting ??= setTimeout(() => { waiting = null; show(model, showAxis); }); };
  const model = new Model(at("form"), content, engines, changed);
  const showAxis = dutyAxis(at("duty"), at("dragged"), model);
  show(model, showAxis);
  await attempt(() => restore(location.hash, model));
  listen(model);
  list(at("sliders"), at("search"), model);
  return model;
}

begin();
