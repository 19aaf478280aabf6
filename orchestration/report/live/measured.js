// A measured run: a CSV file with a header of `name [unit]`, read as orchestration/scenarios/duties/duty_files.py does.

const DEMANDS = ["speed", "torque", "ambient_temperature", "pad_mode", "pad_temperature", "pad_power"];

/** Throw an Error with a sentence unless something is well. */
export function demand(well, sentence) {
  if (!well) throw new Error(sentence);
}

/** Cells of a line; quotes hold commas. */
const cells = (line) => line.split(/,(?=(?:[^"]*"[^"]*")*[^"]*$)/).map((cell) => cell.trim().replace(/^"(.*)"$/, "$1"));

/**
 * Rows of a CSV text, each with its filled cells by column: `time` in s from the start, the others as the page shows them.
 *
 * `known` has, for each column, its units with factor and offset. Throws an Error with a sentence.
 */
export function readMeasured(text, known) {
  const lines = text.replace(/^\ufeff/, "").split(/\r?\n/).map((line, i) => [i + 1, cells(line)]);
  const [header, ...filled] = lines.filter(([, found]) => found.some((cell) => cell));
  demand(header, "is empty; give a header and at least two times");
  const columns = header[1].map((head) => {
    const [, name, unit] = head.match(/^([^[\]]+?)\s*\[([^[\]]*)\]$/) ?? [];
    demand(name, `column '${head}' is not of the form 'name [unit]'; rename it`);
    demand(known[name], `column '${name}' is not known; use one of ${Object.keys(known).join(", ")}, or remove it`);
    const [units, where] = [known[name], `column '${name}':`];
    demand(units[unit], `${where} this page does not know the unit '${unit}'; use one of ${Object.keys(units).join(", ")}`);
    return [name, ...units[unit]];
  });
  const names = columns.map(([name]) => name);
  const twice = names.find((name, i) => names.indexOf(name) !== i);
  demand(!twice, `column '${twice}' stands twice; keep one`);
  demand(names.includes("time"), "no column 'time [s]'; add it");
  let before = -Infinity;
  const rows = filled.map(([number, found]) => {
    const check = (well, sentence) => demand(well, `line ${number}: ${sentence}`);
    check(found.length === columns.length, `${found.length} cells under ${columns.length} columns; mend the row`);
    const row = {};
    columns.forEach(([name, factor, offset], i) => {
      if (!found[i]) return;
      row[name] = factor * found[i] + offset;
      check(Number.isFinite(row[name]), `'${found[i]}' in column '${name}' is no number; mend or empty it`);
    });
    check(row.time > before, "time is missing or does not increase; give increasing times");
    check(!("pad_temperature" in row && "pad_power" in row), "pad_temperature and pad_power exclude each other; give one");
    before = row.time;
    return row;
  });
  demand(rows.length > 1, `${rows.length} rows under the header; give at least two times`);
  return rows.map((row) => ({ ...row, time: row.time - rows[0].time }));
}

/** Segments of a measured duty: equal rows are one. Empty cells hold; an empty pad cell switches it off. */
export function measuredSegments(rows, first) {
  const segments = [];
  let held = { ...first, speed: 0, torque: 0 };
  rows.slice(0, -1).forEach((row, i) => {
    const pad_mode = "pad_temperature" in row ? 2 : "pad_power" in row ? 1 : 0;
    held = { ...held, ...row, pad_mode, duration: rows[i + 1].time - row.time };
    const last = segments.at(-1);
    if (last && DEMANDS.every((name) => last[name] === held[name])) last.duration += held.duration;
    else segments.push(held);
  });
  return segments;
}
