// A measured run: a CSV file with a header of `name [unit]`, read as orchestration/scenarios/duties/duty_csv.py does.

/** Rows of cells; quotes hold commas. */
function cells(line) {
  return [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) => quoted?.replaceAll('""', '"') ?? plain);
}

function column(header, known, where) {
  const [, name, unit] = header.trim().match(/^([^[\]]+?)\s*\[([^[\]]*)\]$/) ?? [];
  if (!name) throw new Error(`${where}: column '${header}' is not of the form 'name [unit]'; rename it`);
  if (!(name in known)) throw new Error(`${where}: column '${name}' is not known; use one of ${Object.keys(known).join(", ")}, or remove it`);
  const { units } = known[name];
  if (!(unit in units)) throw new Error(`${where}: column '${name}': this page does not know the unit '${unit}'; use one of ${Object.keys(units).join(", ")}`);
  return { name, to: (value) => units[unit][0] * value + units[unit][1] };
}

/**
 * Read a CSV text: `times` in s, and the other columns by name in SI units, NaN where a cell is empty.
 *
 * `known` has, for each column, its units with factor and offset into SI. Throws an Error with a sentence.
 */
export function readMeasured(text, known, where) {
  const rows = text.replace(/^\ufeff/, "").split(/\r?\n/).map((line, i) => [i + 1, line]).filter(([, line]) => line.replaceAll(",", "").trim());
  if (!rows.length) throw new Error(`${where}: is empty; give a header and at least two times`);
  const columns = cells(rows[0][1]).map((header) => column(header, known, where));
  const names = columns.map(({ name }) => name);
  const twice = names.find((name, i) => names.indexOf(name) !== i);
  if (twice) throw new Error(`${where}: column '${twice}' stands twice; keep one`);
  if (!names.includes("time")) throw new Error(`${where}: no column 'time [s]'; add it`);
  const series = Object.fromEntries(names.map((name) => [name, []]));
  for (const [number, line] of rows.slice(1)) {
    const found = cells(line);
    if (found.length !== names.length) throw new Error(`${where}: line ${number}: ${found.length} cells under ${names.length} columns; mend the row`);
    columns.forEach(({ name, to }, i) => {
      const value = found[i].trim() === "" ? NaN : Number(found[i]);
      if (found[i].trim() && !Number.isFinite(value)) throw new Error(`${where}: line ${number}: '${found[i].trim()}' in column '${name}' is no number; mend or empty it`);
      series[name].push(to(value));
    });
    const [now, before] = [series.time.at(-1), series.time.at(-2)];
    if (Number.isNaN(now) || now <= before) throw new Error(`${where}: line ${number}: time is missing or does not increase; give increasing times`);
  }
  const { time, ...others } = series;
  if (time.length < 2) throw new Error(`${where}: ${time.length} rows under the header; give at least two times`);
  return { times: time.map((each) => each - time[0]), series: others };
}

/** Segments of a measured duty: equal rows after another are one. Empty cells hold; an empty pad cell switches it off. */
export function measuredSegments({ times, series }, first) {
  const segments = [];
  let held = { ...first, pad_mode: [0], speed: [0], torque: [0] };
  times.slice(0, -1).forEach((time, i) => {
    const given = (name) => (name in series && !Number.isNaN(series[name][i]) ? [series[name][i]] : null);
    for (const name of ["speed", "torque", "ambient_temperature", "pad_temperature", "pad_power"]) held = { ...held, [name]: given(name) ?? held[name] };
    held = { ...held, pad_mode: [given("pad_temperature") ? 2 : given("pad_power") ? 1 : 0] };
    const duration = times[i + 1] - time;
    const last = segments.at(-1);
    if (last && JSON.stringify({ ...last, duration: 0 }) === JSON.stringify({ ...held, duration: 0 })) last.duration += duration;
    else segments.push({ ...held, duration });
  });
  return segments;
}
