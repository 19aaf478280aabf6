// What takes the page's state elsewhere: its address, the commands that compute the same, files.

/** What was changed as the part of an address after #. */
export const address = (model) => `#${new URLSearchParams(model.changed().map((name) => [name, model.text(name)]))}`;

/** Take over the changes of an address; throws an Error with a sentence where they do not fit this page. */
export function restore(hash, model) {
  const given = Object.fromEntries(new URLSearchParams(hash.slice(1)));
  const fits = ([name, text]) => {
    const field = model.fields.get(name)?.cloneNode(true) ?? {};
    field.value = text;
    return field.checkValidity?.() && Number.isFinite(Number(text));
  };
  const shown = Object.keys(model.content.laws).some((law) => given[`law:${law}`] !== "0");
  if (!shown || !Object.entries(given).every(fits))
    throw new Error("The address holds settings that do not fit this page, which begins with its scenario's; mend or shorten it");
  model.put(given);
}

/** Parameters as they are written: given ones, and those set on the page. */
function settings(model, given) {
  const set = model.changed("parameter").map((name) => [name, model.quantity(name)]);
  return { ...given, ...Object.fromEntries(set) };
}

/** Whether only a file can say what was changed: the duty cycle, or a value that a mismatch would change once more. */
export function needsFile(model) {
  const kinds = model.content.mismatched ? ["duty", "parameter"] : ["duty"];
  return kinds.some((kind) => model.changed(kind).length);
}

/** A command with options as a shell takes them. */
function line(program, file, options) {
  const word = (text) => (/^[\w./-]+$/.test(text) ? text : `"${text}"`);
  return [`warmlink ${program} ${word(file)}`, ...options.map(([option, value]) => `${option} ${word(value)}`)].join(" ");
}

/** The commands that compute the figures of each law and, in the cell as it is set, diagnose a measured run. */
export function commands(model) {
  const { name, asked, given, options } = model.content;
  const sets = Object.entries(settings(model, given)).map(([each, value]) => ["--set", `${each}=${value}`]);
  const stop = model.changed("page").includes("stop") ? [["--stop", model.quantity("stop")]] : [];
  const others = options.filter(([option]) => option !== "--stop" || !stop.length);
  const [file, more] = needsFile(model) ? [`${name}_live.toml`, []] : [asked, [...others, ...stop, ...sets]];
  const runs = model.laws.map((law) => line("run", file, [["--controller", law], ...more]));
  return model.measured ? [...runs, line("diagnose", model.measured.name, sets)] : runs;
}

/** The scenario with the first law as a TOML file, as the page has it. */
export function scenarioText(model) {
  const { scenario: { top, tables, parameters }, drivers } = model.content;
  const segment = (_, i) => {
    const told = {};
    for (const { name, word } of model.vectors) told[word] = [...(told[word] ?? []), model.quantity(`${name}[${i + 1}]`)];
    const { duration, pad_mode, pad_power, pad_temperature, ...demands } = told;
    const pad = [{}, { pad_power }, { pad_temperature }][pad_mode];
    const each = Object.entries({ duration, ...demands, ...pad }).map(([word, all]) => [word, all.length > 1 ? all : all[0]]);
    return ["[[segment]]", Object.fromEntries(each)];
  };
  const repeat = model.get(`${drivers[0]}.repeat`) ? { repeat: true } : {};
  const parts = [
    ["", { ...top, controller: model.laws[0], stop_time: model.quantity("stop"), ...repeat }],
    ...model.segments.map(segment),
    ...tables,
    ["[parameters]", settings(model, parameters)],
  ];
  const entry = ([key, value]) => `${/^\w+$/.test(key) ? key : JSON.stringify(key)} = ${JSON.stringify(value)}`;
  return parts.map(([heading, table]) => [heading, ...Object.entries(table).map(entry)].join("\n")).join("\n\n");
}

/** The parameters set on the page as an SSP parameter set. */
export function parameterSet(model) {
  const each = (name) => `<ssv:Parameter name="${name}"><ssv:Real value="${model.get(name)}"/></ssv:Parameter>`;
  const parameters = model.changed("parameter").map(each).join("\n");
  return model.content.ssv.replace("<ssv:Parameters/>", `<ssv:Parameters>${parameters}</ssv:Parameters>`);
}
