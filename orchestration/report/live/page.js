// The page: it runs the system whenever something changes, and shows what comes of it.

import { copies, drawDuty } from "./duty.js";
import { engine } from "./engine.js";
import { digits, errorFigures, removed, since } from "./figures.js";
import { demand, measuredSegments, readMeasured } from "./measured.js";
import { at, changed, content, engines, fields, measured, put, reset, run, start, texts } from "./model.js";
import { drawLines } from "./plot.js";
import { address, commands, needsFile, parameterSet, restore, scenarioText } from "./share.js";
import { rank, showSliders, slid } from "./sliders.js";

const ADDRESS_AFTER = 400; // ms without a change; browsers refuse an address that changes a hundred times in half a minute

const waiting = {}; // timers

let accepted = start; // what the fields showed before the last change

/** What a line of a plot shows, where its law is chosen: a function of variable and law. */
function results() {
  const runs = Object.fromEntries(texts().law.split(",").map((law) => [law, run(law)]));
  return (variable, law) => (law ? runs[law] : Object.values(runs)[0])?.[variable];
}

/** Figures of the errors that are drawn, by the names of their lines. */
function figuresOf(values) {
  const drawn = content.plots[0].lines.map(([name, ...line]) => [name, values(...line)]).filter(([, error]) => error);
  return drawn.map(([name, error]) => [name, errorFigures(error, content.step, content.tolerance)]);
}

function showAnswer(figures) {
  const micrometres = (value) => `${value.toFixed(1)} µm`;
  const rows = {
    figure: (of, law) => law,
    "largest error": (of) => micrometres(of.largest),
    "of the largest error": (of) => (of === figures[0][1] ? "" : removed(figures[0][1], of)),
    "95 % of the time below": (of) => micrometres(of.p95),
    "root mean square": (of) => micrometres(of.rms),
    [`within ±${digits(1e6 * content.tolerance)} µm from`]: (of) => since(of.within),
  };
  const cells = (told) => figures.map(([law, of]) => `<td>${told(of, law)}</td>`).join("");
  const lines = Object.entries(rows).map(([name, told]) => `<tr><th scope="row">${name}</th>${cells(told)}</tr>`);
  at("answer").innerHTML = lines.join("");
  const largest = figures.map(([law, of]) => `${law} ${micrometres(of.largest)}`);
  at("lead").textContent = `Largest error of the tool point: ${largest.join(", ")}.`;
}

function showPlots(values) {
  content.plots.forEach(({ factor, zero, lines, ...plot }, i) => {
    const drawn = lines.map(([name, variable, law, column]) => {
      const marks = measured.rows.filter((row) => column in row).map((row) => [row.time, row[column]]);
      return { name, marks, values: values(variable, law)?.map((value) => factor * (value - zero)) };
    });
    drawLines(at(`plot-${i}`), { ...plot, step: content.step, lines: drawn });
  });
}

/** What a reader should know of the laws, and what computes the same elsewhere: commands, files, the address. */
function showWords() {
  const noted = Object.entries(content.laws).filter(([law, { note }]) => note && texts().law.split(",").includes(law));
  at("notes").textContent = noted.map(([law, { note }]) => `${law}: ${note}.`).join(" ");
  at("notes").hidden = Object.keys(changed("parameter")).length > 0;
  at("command").textContent = commands().join("\n");
  at("scenario-note").hidden = !needsFile();
  for (const [id, text] of [["scenario", scenarioText()], ["parameters", parameterSet()]])
    at(id).href = `data:text/plain;charset=utf-8,${encodeURIComponent(text)}`;
  clearTimeout(waiting.address);
  waiting.address = setTimeout(() => history.replaceState(null, "", address()), ADDRESS_AFTER);
}

/** Take a measured run: its duty where it holds one, and its readings over the lines. */
async function take(file) {
  const { columns, most, repeat, step, words } = content;
  const rows = readMeasured(await file.text(), columns);
  const given = { stop: digits(step * Math.floor(rows.at(-1).time / step), 12) };
  if (rows.some((row) => "speed" in row || "torque" in row)) {
    demand(words.speed.length === 1, "the page takes measured runs of a single axis only");
    const first = Object.entries(words).map(([word, [name]]) => [word, Number(fields(name)[0].defaultValue)]);
    const segments = measuredSegments(rows, Object.fromEntries(first));
    const many = `${segments.length} segments are more than the ${most} that the page takes`;
    demand(segments.length <= most, `${many}; average the duty over longer times`);
    for (const [word, [name]] of Object.entries(words)) given[name] = segments.map((each) => digits(each[word], 12)).join();
    given[repeat] = "0";
  }
  Object.assign(measured, { name: file.name, rows });
  put(given);
}

/** Do what a button or a file asks for; what is refused is said in a sentence. */
async function attempt(action, where = "") {
  try {
    await action();
  } catch (fault) {
    at("fault").textContent = `${where}${fault.message}.`;
  }
}

function show() {
  const begun = performance.now();
  attempt(() => {
    const values = results();
    showAnswer(figuresOf(values));
    showPlots(values);
    showWords();
  });
  drawDuty();
  showSliders();
  at("time").textContent = `computed and drawn in ${(performance.now() - begun).toFixed(0)} ms`;
}

/** What buttons do, by their names. */
const actions = {
  copy: () => navigator.clipboard.writeText(at("command").textContent),
  anew: reset,
  back: ({ value }) => put({ [value]: start[value] }),
  copies: (button) => copies(button.closest("tr").sectionRowIndex, Number(button.value)),
};

/** Follow what the reader types, drags, presses and drops. */
function listen() {
  const load = ({ files: [file] }) => file && attempt(() => take(file), `${file.name}: `);
  at("form").addEventListener("change", ({ target }) => {
    if (target.files) return load(target);
    at("fault").textContent = "";
    if (target.validity?.valid === false) return put(accepted);
    if (!texts().law) target.checked = true;
    accepted = texts();
    for (const fault of at("faults").querySelectorAll("input"))
      fault.disabled = fault.closest("tr").querySelector("select").value === "0";
    clearTimeout(waiting.show);
    waiting.show = setTimeout(show);
  });
  at("form").addEventListener("input", ({ target }) => target.type === "range" && slid(target));
  at("form").addEventListener("click", ({ target }) => target.name in actions && attempt(() => actions[target.name](target)));
  at("search").addEventListener("input", showSliders);
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    load(event.dataTransfer);
  });
}

async function unpacked(law) {
  const bytes = Uint8Array.from(atob(at(`module-${law}`).textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

async function begin() {
  for (const law of Object.keys(content.laws)) engines[law] = await engine(await unpacked(law));
  listen();
  show();
  await attempt(() => restore(location.hash));
  rank();
}

begin();
