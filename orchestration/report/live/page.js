// The page: it runs the system whenever something changes, and shows what comes of it.

import { copies, drawDuty, rank, showSliders, slid } from "./controls.js";
import { engine } from "./engine.js";
import { digits, drawLines, errorFigures, lasting, removed } from "./figures.js";
import { demand, measuredSegments, readMeasured, tableOf } from "./measured.js";
import { at, changed, content, fields, laws, measured, put, run, start, texts } from "./model.js";
import { commands, parameterSet, restore, scenarioText, settings } from "./share.js";

const ADDRESS_AFTER = 400; // ms without a change; browsers refuse an address that changes a hundred times in half a minute

let waiting; // timer of what follows a change: the page is drawn, then its address is set

let accepted = start; // what the fields showed before the last change

/** A sentence on what leaves the band in which the model holds, in a run; empty where nothing does. */
function left(of) {
  const outside = ([name, [low, high]]) => of((v, i) => v[name][i]).some((value) => !(value >= low && value <= high));
  const found = Object.entries(content.bands).filter(outside).map(([name, [, , band]]) => `${name} (${band})`);
  return found.length ? `The figures mean little: the model does not hold beyond the range of ${found.join(", ")}.` : "";
}

/** The plots with the lines of the laws that are chosen, and a measured run's readings over them. */
function plots() {
  const chosen = laws();
  const runs = Object.fromEntries(chosen.map((law) => [law, run(law)]));
  at("left").textContent = left(Object.values(runs)[0]);
  const values = ({ law, expression }) => runs[law || chosen[0]]?.(expression);
  const marks = ({ column }) => measured.rows.filter((row) => column in row).map((row) => [row.time, row[column]]);
  const drawn = (line) => ({ ...line, values: values(line), marks: marks(line) });
  return content.plots.map((plot) => ({ ...plot, lines: plot.lines.map(drawn).filter((line) => line.values) }));
}

/** Show the figures of the errors that are drawn. */
function showAnswer({ band, lines }) {
  const figures = lines.map(({ name, values }) => ({ name, ...errorFigures(values, content.step, band) }));
  const row = (name, told) => `<tr><th scope="row">${name}</th>${figures.map((of) => `<td>${told(of)}</td>`).join("")}</tr>`;
  const micrometres = (value) => `${value.toFixed(1)} µm`;
  at("answer").innerHTML = [
    row("figure", ({ name }) => name),
    row("largest error", ({ largest }) => micrometres(largest)),
    row("of the largest error", (of) => removed(figures[0], of)),
    row("95 % of the time below", ({ p95 }) => micrometres(p95)),
    row("root mean square", ({ rms }) => micrometres(rms)),
    row(`within ±${digits(band)} µm from`, ({ within }) => (within ? lasting(within) : within === null ? "never" : "start")),
  ].join("");
  const largest = figures.map(({ name, largest }) => `${name} ${micrometres(largest)}`);
  at("lead").textContent = `Largest error of the tool point: ${largest.join(", ")}.`;
}

/** Show what comes of what the fields say, and what computes the same elsewhere: commands, files, the address. */
function show() {
  const begun = performance.now();
  drawDuty();
  showSliders();
  const drawn = plots();
  showAnswer(drawn[0]);
  drawn.forEach((plot, i) => drawLines(at(`plot-${i}`), plot, content.step));
  at("notes").textContent = Object.keys(settings()).length ? "" : laws().map((law) => content.laws[law].note).join(" ");
  at("command").textContent = commands().join("\n");
  for (const [id, text] of [["scenario", scenarioText()], ["parameters", parameterSet()]])
    at(id).href = `data:text/plain;charset=utf-8,${encodeURIComponent(text)}`;
  at("time").textContent = `computed and drawn in ${(performance.now() - begun).toFixed(0)} ms`;
  waiting = setTimeout(() => history.replaceState(null, "", `#${new URLSearchParams(changed())}`), ADDRESS_AFTER);
}

/** Take a measured run: its duty where it holds one, and its readings over the lines. */
async function take(file) {
  const { columns, most, played, repeat, step, words } = content;
  const rows = readMeasured(await file.text(), columns);
  const [{ min, max }, lasts] = [fields("stop")[0], step * Math.floor(rows.at(-1).time / step)];
  demand(lasts >= min && lasts <= max, `lasts ${digits(rows.at(-1).time)} s; the page takes runs of ${min} s to ${max} s`);
  const given = { stop: digits(lasts, 12) };
  const driven = rows.some((row) => "speed" in row || "torque" in row);
  if (driven && played) {
    const bytes = tableOf(measuredSegments(rows), played);
    for (const { engine } of Object.values(content.laws)) engine.play(0, bytes);
    measured.duty = file.name;
  } else if (driven) {
    demand(words.speed.length === 1, "the page takes measured runs of a single axis only");
    const segments = measuredSegments(rows);
    const remedy = `the page that warmlink live makes of ${file.name} plays them all`;
    demand(segments.length <= most, `${segments.length} segments are above this page's ${most}; ${remedy}`);
    for (const [word, [name]] of Object.entries(words)) given[name] = segments.map((each) => digits(each[word], 12)).join();
    given[repeat] = "0";
  }
  Object.assign(measured, { name: file.name, rows });
  put(given);
}

/** Say in a sentence what was refused. */
const say = ({ message }, where = "") => at("fault").replaceChildren(`${where}${message}.`);

const load = ({ files: [file] }) => file && take(file).catch((refused) => say(refused, `${file.name}: `));

/** What buttons do, by their names. */
const actions = {
  copy: () => navigator.clipboard.writeText(at("command").textContent),
  back: ({ value }) => put({ [value]: start[value] }),
  copies: (button) => copies(button.closest("tr").sectionRowIndex, Number(button.value)),
};

const tables = Array.from(document.querySelectorAll(".table"), ({ textContent }) => textContent);
for (const [name, law] of Object.entries(content.laws)) law.engine = await engine(at(`module-${name}`).textContent, tables);

at("form").addEventListener("change", ({ target }) => {
  if (target.files) return load(target);
  at("fault").replaceChildren();
  if (target.validity?.valid === false || !texts().law) return put(accepted);
  for (const each of at("faults").querySelectorAll("input"))
    each.disabled = each.closest("tr").querySelector("select").value === "0";
  accepted = texts();
  clearTimeout(waiting);
  waiting = setTimeout(show);
});
at("form").addEventListener("input", ({ target }) => (target.type === "range" ? slid(target) : showSliders()));
at("form").addEventListener("click", ({ target }) => actions[target.name]?.(target));
at("form").addEventListener("reset", () => setTimeout(put, 0, start));
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  load(event.dataTransfer);
});
addEventListener("error", ({ error }) => say(error));
addEventListener("unhandledrejection", ({ reason }) => say(reason));
setTimeout(rank);
restore(location.hash);
