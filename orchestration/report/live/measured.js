// A measured run: a CSV file with a header of `name [unit]`, read as orchestration/scenarios/duties/recorded.py does.

const AT_FIRST = { speed: 0, torque: 0, ambient_temperature: 22, pad_mode: 0, pad_temperature: 22, pad_power: 0 };

/** Throw an Error with a sentence unless something is well. */
export function demand(well, sentence) {
  if (!well) throw new Error(sentence);
}

/** Cells of a line; quotes hold commas. */
const cells = (line) => line.match(/(?<=^|,)(?:"[^"]*"|[^,"]+|")*/g).map((cell) => cell.trim().replace(/^"(.*)"$/, "$1"));

/**
 * Rows of a CSV text, each with its filled cells by column: `time` in s from the start, the others as the page shows them.
 *
 * `known` has, for each column, its units with factor and offset. Throws an Error with a sentence.
 */
export function readMeasured(text, known) {
  const lines = text.replace(/^\ufeff/, "").split(/\r?\n/).map((line, i) => [i + 1, cells(line)]);
  const [header, ...filled] = lines.filter(([, found]) => found.some((cell) => cell));
  demand(header, "is empty; give a header and at least two times");
  const columns = new Map();
  for (const head of header[1]) {
    const [, name, unit] = head.match(/^([^[\]]+?)\s*\[([^[\]]*)\]$/) ?? [];
    demand(name, `column '${head}' is not of the form 'name [unit]'; rename it`);
    const [units, where] = [Object.hasOwn(known, name) && known[name], `column '${name}'`];
    demand(units, `${where} is not known; use one of ${Object.keys(known).join(", ")}, or remove it`);
    demand(Object.hasOwn(units, unit), `${where}: this page does not know the unit '${unit}'; use one of ${Object.keys(units).join(", ")}`);
    demand(!columns.has(name), `${where} stands twice; keep one`);
    columns.set(name, units[unit]);
  }
  demand(columns.has("time"), "no column 'time [s]'; add it");
  const rows = [];
  for (const [number, found] of filled) {
    const check = (well, sentence) => demand(well, `line ${number}: ${sentence}`);
    check(found.length === columns.size, `${found.length} cells under ${columns.size} columns; mend the row`);
    const row = {};
    [...columns].forEach(([name, [factor, offset]], i) => {
      if (!found[i]) return;
      row[name] = factor * found[i] + offset;
      check(Number.isFinite(row[name]), `'${found[i]}' in column '${name}' is no number; mend or empty it`);
    });
    check(row.time > (rows.at(-1)?.time ?? -Infinity), "time is missing or does not increase; give increasing times");
    check(!("pad_temperature" in row && "pad_power" in row), "pad_temperature and pad_power exclude each other; give one");
    rows.push(row);
  }
  demand(rows.length > 1, `${rows.length} rows under the header; give at least two times`);
  return rows.map((row) => ({ ...row, time: row.time - rows[0].time }));
}

/** Segments of a measured duty: equal rows are one. Empty cells hold; an empty pad cell switches it off. */
export function measuredSegments(rows) {
  const segments = [];
  let held = AT_FIRST;
  rows.slice(0, -1).forEach((row, i) => {
    const pad_mode = "pad_temperature" in row ? 2 : "pad_power" in row ? 1 : 0;
    held = { ...held, ...row, pad_mode, duration: rows[i + 1].time - row.time };
    const last = segments.at(-1);
    if (last && Object.keys(AT_FIRST).every((name) => last[name] === held[name])) last.duration += held.duration;
    else segments.push(held);
  });
  return segments;
}
