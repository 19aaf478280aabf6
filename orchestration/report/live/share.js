// What takes the page's state elsewhere: its address, the commands that compute the same, files.

import { changed, content, fields, inSi, measured, put, quantity, reset, texts } from "./model.js";

/** What was changed as the part of an address after #. */
export const address = () => `#${new URLSearchParams(changed())}`;

/** Take over the changes of an address; throws an Error with a sentence where they do not fit this page. */
export function restore(hash) {
  const given = Object.fromEntries(new URLSearchParams(hash.slice(1)));
  put(given);
  const shown = texts();
  const fits = ([name, text]) => text === shown[name] && [...fields(name)].every(({ validity }) => validity.valid);
  if (Object.entries(given).every(fits)) return;
  reset();
  throw new Error("The address holds settings that do not fit this page, which begins with its scenario's; mend or shorten it");
}

/** Parameters as they are written: given ones, and those set on the page. */
function settings(given) {
  const set = Object.entries(changed("parameter")).map(([name, text]) => [name, quantity(name, text)]);
  return { ...given, ...Object.fromEntries(set) };
}

/** Whether only a file can say what was changed: the duty cycle, or a value that a mismatch would change once more. */
export const needsFile = () => Object.keys(changed()).some((name) => "file" in fields(name)[0].dataset);

/** The commands that compute the figures of each law and, in the cell as it is set, diagnose a measured run. */
export function commands() {
  const { name, asked, given, options } = content;
  const word = (text) => (/^[\w./-]+$/.test(text) ? text : `"${text}"`);
  const line = (...words) => ["warmlink", ...words].map(word).join(" ");
  const sets = Object.entries(settings(given)).flatMap(([each, value]) => ["--set", `${each}=${value}`]);
  const stop = "stop" in changed() ? ["--stop", quantity("stop", texts().stop)] : [];
  const others = options.filter(([option]) => !stop.includes(option)).flat();
  const more = needsFile() ? [`${name}_live.toml`] : [asked, ...others, ...stop, ...sets];
  const runs = texts().law.split(",").map((law) => line("run", ...more, "--controller", law));
  return measured.name ? [...runs, line("diagnose", measured.name, ...sets)] : runs;
}

/** The scenario with the first law as a TOML file, as the page has it. */
export function scenarioText() {
  const { scenario: { top, tables, parameters }, repeat, words } = content;
  const shown = texts();
  const segment = (_, i) => {
    const of = (name) => quantity(name, shown[name].split(",")[i]);
    const told = Object.entries(words).map(([word, names]) => [word, names.length > 1 ? names.map(of) : of(names[0])]);
    const { pad_mode, pad_power, pad_temperature, ...demands } = Object.fromEntries(told);
    return ["[[segment]]", { ...demands, ...[{}, { pad_power }, { pad_temperature }][pad_mode] }];
  };
  const [controller] = shown.law.split(",");
  const parts = [
    ["", { ...top, controller, stop_time: quantity("stop", shown.stop), repeat: shown[repeat] === "1" }],
    ...shown[words.duration[0]].split(",").map(segment),
    ...tables,
    ["[parameters]", settings(parameters)],
  ];
  const entry = ([key, value]) => `${/^\w+$/.test(key) ? key : JSON.stringify(key)} = ${JSON.stringify(value)}`;
  return parts.map(([heading, table]) => [heading, ...Object.entries(table).map(entry)].join("\n")).join("\n\n");
}

/** The parameters set on the page as an SSP parameter set. */
export function parameterSet() {
  const each = ([name, text]) => `<ssv:Parameter name="${name}"><ssv:Real value="${inSi(name, text)}"/></ssv:Parameter>`;
  const parameters = Object.entries(changed("parameter")).map(each).join("\n");
  return content.ssv.replace("<ssv:Parameters/>", `<ssv:Parameters>${parameters}</ssv:Parameters>`);
}
