// A measured run: a CSV file with a header of `name [unit]`, read as orchestration/scenarios/duties/duty_files.py does.

const HELD = ["speed", "torque", "ambient_temperature", "pad_temperature", "pad_power"];

/** Cells of a line; quotes hold commas. */
const cells = (line) => [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)]
  .map(([, quoted, plain]) => (quoted?.replaceAll('""', '"') ?? plain).trim());

const listed = (table) => Object.keys(table).join(", ");

/**
 * Read a CSV text: `times` in s, and the other columns by name in SI units, NaN where a cell is empty.
 *
 * `known` has, for each column, its units with factor and offset into SI. Throws an Error with a sentence.
 */
export function readMeasured(content, known, where) {
  const demand = (well, sentence) => { if (!well) throw new Error(`${where}: ${sentence}`); };
  const lines = content.replace(/^\ufeff/, "").split(/\r?\n/).map((each, i) => [i + 1, cells(each)]);
  const [header, ...rows] = lines.filter(([, found]) => found.some((cell) => cell));
  demand(header, "is empty; give a header and at least two times");
  const columns = header[1].map((head) => {
    const [, name, unit] = head.match(/^([^[\]]+?)\s*\[([^[\]]*)\]$/) ?? [];
    demand(name, `column '${head}' is not of the form 'name [unit]'; rename it`);
    demand(known[name], `column '${name}' is not known; use one of ${listed(known)}, or remove it`);
    const { units } = known[name];
    demand(units[unit], `column '${name}': this page does not know the unit '${unit}'; use one of ${listed(units)}`);
    return { name, factor: units[unit][0], offset: units[unit][1], values: [] };
  });
  const twice = columns.find(({ name }, i) => columns.findIndex((each) => each.name === name) !== i);
  demand(!twice, `column '${twice?.name}' stands twice; keep one`);
  const { time, ...series } = Object.fromEntries(columns.map(({ name, values }) => [name, values]));
  demand(time, "no column 'time [s]'; add it");
  for (const [number, found] of rows) {
    demand(found.length === columns.length, `line ${number}: ${found.length} cells under ${columns.length} columns; mend the row`);
    columns.forEach(({ name, factor, offset, values }, i) => {
      const value = found[i] === "" ? NaN : factor * Number(found[i]) + offset;
      demand(!found[i] || Number.isFinite(value), `line ${number}: '${found[i]}' in column '${name}' is no number; mend or empty it`);
      values.push(value);
    });
    const later = time.at(-1) > (time.at(-2) ?? -Infinity);
    demand(later, `line ${number}: time is missing or does not increase; give increasing times`);
  }
  demand(time.length > 1, `${time.length} rows under the header; give at least two times`);
  return { times: time.map((each) => each - time[0]), series };
}

/** Segments of a measured duty: equal rows are one. Empty cells hold; an empty pad cell switches it off. */
export function measuredSegments({ times, series }, first) {
  const segments = [];
  let held = { ...first, speed: 0, torque: 0 };
  times.slice(0, -1).forEach((time, i) => {
    const given = HELD.filter((name) => Number.isFinite(series[name]?.[i]));
    const pad_mode = given.includes("pad_temperature") ? 2 : given.includes("pad_power") ? 1 : 0;
    held = { ...held, ...Object.fromEntries(given.map((name) => [name, series[name][i]])), pad_mode };
    const [last, duration] = [segments.at(-1), times[i + 1] - time];
    if (last && Object.keys(held).every((name) => held[name] === last[name])) last.duration += duration;
    else segments.push({ ...held, duration });
  });
  return segments;
}
