// What takes the page's state elsewhere: its address, the commands that compute the same, files.

import { escaped } from "./figures.js";
import { at, changed, content, fields, inSi, laws, measured, put, quantity, start, texts } from "./model.js";

/** Take over the changes that an address holds after #; throws an Error with a sentence where they do not fit this page. */
export function restore(hash) {
  const given = Object.fromEntries(new URLSearchParams(hash.slice(1)));
  put(given);
  const fits = ([name, text]) => text === texts()[name] && [...fields(name)].every(({ validity }) => validity.valid);
  if (Object.entries(given).every(fits)) return;
  for (const each of at("faults").querySelectorAll("input")) each.value = each.defaultValue; // `start` lacks disabled ones
  put(start);
  throw new Error("The address holds settings that do not fit this page, which begins with its scenario's; mend or shorten it");
}

const isParameter = ([name]) => fields(name)[0].dataset.kind === "parameter";

/** Parameters that are set on the page, as they are written. */
export const settings = () =>
  Object.fromEntries(Object.entries(changed()).filter(isParameter).map(([name, text]) => [name, quantity(name, text)]));

/** Whether only a file can say what was changed: the duty cycle, or a value that a mismatch would change once more. */
const needsFile = () => measured.duty || Object.keys(changed()).some((name) => "file" in fields(name)[0].dataset);

/** A word of a command as a shell reads it; names may hold anything, and none of it may run. */
const quoted = (word) =>
  /^[\w./-]+$/.test(word) ? word : /["$`\\!]/.test(word) ? `'${word.replaceAll("'", "'\\''")}'` : `"${word}"`;

/** The commands that compute the figures of each law and, in the cell as it is set, diagnose a measured run. */
export function commands() {
  const { name, asked, given, options } = content;
  const line = (...words) => ["warmlink", ...words].map(quoted).join(" ");
  const sets = Object.entries({ ...given, ...settings() }).flatMap(([each, value]) => ["--set", `${each}=${value}`]);
  const stop = "stop" in changed() ? { "--stop": quantity("stop", texts().stop) } : {};
  const more = needsFile() ? [`${name}_live.toml`] : [...asked, ...Object.entries({ ...options, ...stop }).flat(), ...sets];
  const runs = laws().map((law) => line("run", ...more, "--controller", law));
  return measured.name ? [...runs, line("diagnose", measured.name, ...sets)] : runs;
}

/** Lines of a table in a TOML file. */
const lines = (table) =>
  Object.entries(table).map(([key, value]) => `${/\W/.test(key) ? JSON.stringify(key) : key} = ${JSON.stringify(value)}`);

/** The scenario with the first law as a TOML file, as the page has it. */
export function scenarioText() {
  const { scenario: { top, tables, parameters }, repeat, words } = content;
  const shown = texts();
  const durations = words.duration ? shown[words.duration[0]].split(",") : [];
  const segments = durations.flatMap((_, i) => {
    const of = (name) => quantity(name, shown[name].split(",")[i]);
    const told = Object.entries(words).map(([word, names]) => [word, names.length > 1 ? names.map(of) : of(names[0])]);
    const { pad_mode, pad_power, pad_temperature, ...demands } = Object.fromEntries(told);
    return ["", "[[segment]]", ...lines({ ...demands, ...[{}, { pad_power }, { pad_temperature }][pad_mode] })];
  });
  const now = { controller: laws()[0], stop_time: quantity("stop", shown.stop) };
  if (repeat) now.repeat = shown[repeat] === "1";
  const recorded = top.filter((line) => !measured.duty || !/^(duty|linear) = /.test(line));
  if (measured.duty) now.duty = measured.duty;
  return [...recorded, ...lines(now), ...segments, ...tables, "", "[parameters]", ...lines({ ...parameters, ...settings() })].join("\n");
}

/** The parameters set on the page as an SSP parameter set. */
export function parameterSet() {
  const each = (name) => `<ssv:Parameter name="${escaped(name)}"><ssv:Real value="${inSi(name, texts()[name])}"/></ssv:Parameter>`;
  const parameters = Object.keys(settings()).map(each).join("\n");
  return content.ssv.replace("<ssv:Parameters/>", `<ssv:Parameters>${parameters}</ssv:Parameters>`);
}
