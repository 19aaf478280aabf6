// What takes the page's state elsewhere: its address, the commands that compute the same, files.

const unit = (si) => (si === "1" ? "" : ` ${si}`);
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** The state as the part of an address after #: what differs from the start. */
export function address({ state, start }) {
  const different = Object.entries(state).filter(([key, value]) => !same(value, start[key]));
  return different.length ? `#${encodeURIComponent(JSON.stringify(Object.fromEntries(different)))}` : "#";
}

/** The state of an address; throws an Error with a sentence where it does not fit this page. */
export function restored(hash, { content, start }) {
  if (hash.length < 2) return start;
  try {
    const state = { ...start, ...JSON.parse(decodeURIComponent(hash.slice(1))) };
    const known = new Set(content.parameters.map(({ name }) => name));
    const demands = Object.keys(start.segments[0]);
    const fits = state.laws.length && state.laws.every((law) => law in content.laws) && state.stop > 0 &&
      Object.entries(state.values).every(([name, value]) => known.has(name) && Number.isFinite(value)) &&
      state.segments.length && state.segments.every((segment) => demands.every((name) => name in segment));
    if (fits) return state;
  } catch {
    // Said below.
  }
  throw new Error("The address holds settings that do not fit this page, which begins with its scenario's; mend or shorten it");
}

const dutyChanged = ({ state, start }) => !same([state.segments, state.repeat], [start.segments, start.repeat]);

/** Whether only a file can say what was changed: the duty cycle, or a value that a mismatch would change once more. */
export const needsFile = (model) => dutyChanged(model) || (model.content.mismatched && Object.keys(model.state.values).length > 0);

export const scenarioFile = ({ content }) => `${content.name}_live.toml`;

/** The command that computes a law's figures. */
export function command(model, law) {
  const { content, state, start } = model;
  if (needsFile(model)) return `warmlink run ${word(scenarioFile(model))} --controller ${law}`;
  const asked = state.stop === start.stop ? content.options
    : [...content.options.filter(([option]) => option !== "--stop"), ["--stop", `${state.stop} s`]];
  const options = [["--controller", law], ...asked, ...sets(model)];
  return `warmlink run ${word(content.asked)}${options.map(quoted).join("")}`;
}

/** The command that diagnoses a measured run, in the cell as it is set. */
export const diagnosis = (model, file) =>
  `warmlink diagnose ${word(file)}${sets(model).map(quoted).join("")}`;

const word = (text) => (/^[\w./-]+$/.test(text) ? text : `"${text}"`);
const quoted = ([option, value]) => ` ${option} ${word(value)}`;
const sets = (model) => settings(model, model.content.given).map(([name, value]) => ["--set", `${name}=${value}`]);

/** Parameters as they are written: given ones, and those set on the page. */
function settings({ content, state }, given) {
  const units = Object.fromEntries(content.parameters.map(({ name, si }) => [name, unit(si)]));
  const set = Object.entries(state.values).map(([name, value]) => [name, `${value}${units[name]}`]);
  return Object.entries({ ...given, ...Object.fromEntries(set) });
}

const written = (value) => (Array.isArray(value) ? `[${value.map(written).join(", ")}]` : JSON.stringify(value));
const lines = (table) => Object.entries(table).map(([key, value]) => `${/^\w+$/.test(key) ? key : JSON.stringify(key)} = ${written(value)}\n`).join("");

/** The scenario with a law as a TOML file, as the page has it. */
export function scenarioText(model, law) {
  const { top, tables, parameters, poses } = model.content.scenario;
  const { segments, stop, repeat } = model.state;
  const of = (values, si) => (values.length > 1 ? values.map((value) => `${value} ${si}`) : `${values[0]} ${si}`);
  const pads = [() => ({}), ({ pad_power }) => ({ pad_power: `${pad_power[0]} W` }), ({ pad_temperature }) => ({ pad_temperature: `${pad_temperature[0]} K` })];
  const segment = (each) => ({
    duration: `${each.duration} s`, speed: of(each.speed, "rad/s"), torque: of(each.torque, "N.m"),
    ambient_temperature: `${each.ambient_temperature[0]} K`, ...pads[each.pad_mode[0]](each),
  });
  return [
    lines({ ...top, controller: law, stop_time: `${stop} s`, ...(repeat ? { repeat } : {}) }),
    ...segments.map((each) => `[[segment]]\n${lines(segment(each))}`),
    ...poses.map((each) => `[[pose]]\n${lines(each)}`),
    ...Object.entries(tables).map(([name, table]) => `[${name}]\n${lines(table)}`),
    `[parameters]\n${lines(Object.fromEntries(settings(model, parameters)))}`,
  ].join("\n");
}

/** The parameters set on the page as an SSP parameter set. */
export function parameterSet({ state, content }) {
  const each = Object.entries(state.values).map(([name, value]) => `    <ssv:Parameter name="${name}"><ssv:Real value="${value}"/></ssv:Parameter>\n`);
  return '<?xml version="1.0" encoding="UTF-8"?>\n' +
    `<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="${content.name}">\n` +
    `  <ssv:Parameters>\n${each.join("")}  </ssv:Parameters>\n</ssv:ParameterSet>\n`;
}
