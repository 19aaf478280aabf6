// A measured run: a text of columns under headers of `name [unit]`, read as orchestration/scenarios/duties/recorded.py does.

const AT_FIRST = { speed: 0, torque: 0, ambient_temperature: 22, pad_mode: 0, pad_temperature: 22, pad_power: 0 };

/** Throw an Error with a sentence unless something is well. */
export function demand(well, sentence) {
  if (!well) throw new Error(sentence);
}

const SEPARATORS = [",", ";", "\t", "|"];

/** Cells of a line; quotes hold separators. */
const cells = (line, separator) =>
  line.match(new RegExp(`(?<=^|[${separator}])(?:"[^"]*"|[^${separator}"]+|")*`, "g")).map((cell) => cell.trim().replace(/^"(.*)"$/, "$1"));

/** Name and unit of a header: `Tip temperature [degC]`, `tip_temperature (degC)` or `tip_temperature_degC`. */
function heading(head, known) {
  const [, name, unit] = head.match(/^([^[\]()]+?)\s*[[(]([^[\]()]*)[\])]$/) ?? [];
  if (name) return [name.toLowerCase().replace(/\W+/g, "_"), unit.trim()];
  const first = Object.keys(known).find((each) => head.toLowerCase().startsWith(`${each}_`));
  return first ? [first, head.slice(first.length + 1)] : [];
}

/** What makes points of the decimal commas in cells, where there are such. */
function decimal(filled, separator) {
  const numbers = filled.flatMap(([, found]) => found).filter((cell) => /^[-+.,\de]+$/i.test(cell));
  const commas = separator === "," ? [] : numbers.filter((cell) => cell.includes(","));
  if (!commas.length) return (cell) => cell;
  demand(!numbers.some((cell) => cell.includes(".")), "has numbers with commas and with points; write one decimal mark");
  const thousands = commas.every((cell) => /^[-+]?[1-9]\d{0,2}(,\d{3})+$/.test(cell));
  demand(!thousands, `'${commas[0]}' may have a decimal mark or one for thousands; write decimal points`);
  return (cell) => cell.replace(",", ".");
}

/**
 * Rows of a CSV text, each with its filled cells by column: `time` in s from the start, the others as the page shows them.
 *
 * `known` has, for each column, its units with factor and offset. Throws an Error with a sentence.
 */
export function readMeasured(text, known) {
  const written = text.replace(/^\ufeff/, "").split(/\r?\n/).map((line, i) => [i + 1, line]);
  const lines = written.filter(([, line]) => line.trim() && !/^"?(#|sep=)/.test(line));
  const many = (separator) => lines[0][1].split(separator).length;
  const separator = lines.length ? SEPARATORS.reduce((best, each) => (many(each) > many(best) ? each : best)) : ",";
  const [header, ...filled] = lines.map(([i, line]) => [i, cells(line, separator)]).filter(([, found]) => found.some((cell) => cell));
  demand(header, "is empty; give a header and at least two times");
  const pointed = decimal(filled, separator);
  const columns = new Map();
  for (const head of header[1]) {
    const [name, unit] = heading(head, known);
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
      if (!found[i] || (name.startsWith("pad_") && /^(off|none)$/i.test(found[i]))) return;
      row[name] = factor * pointed(found[i]) + offset;
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

/** CRC-32 of bytes, as zlib computes it. */
function checksum(bytes) {
  const step = (c) => (c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1);
  const table = Array.from({ length: 256 }, (_, i) => Array.from({ length: 8 }).reduce(step, i));
  return (bytes.reduce((crc, byte) => table[(crc ^ byte) & 255] ^ (crc >>> 8), -1) ^ -1) >>> 0;
}

/**
 * The file of a table (fmus/recorded_duty/README.md) that plays a measured duty's segments, each held until the next.
 *
 * `head` is its first line, `columns` has for each column factor and zero of what the page shows of it.
 */
export function tableOf(segments, { head, columns }) {
  const [names, count] = [Object.keys(columns), segments.length];
  const begins = [];
  segments.reduce((time, { duration }) => (begins.push(time), time + duration), 0);
  const [wholes, numbers] = [1 + 2 * names.length, (1 + names.length) * count];
  const text = new TextEncoder().encode(head);
  const bytes = new Uint8Array(text.length + 8 * (wholes + numbers + 1));
  const view = new DataView(bytes.buffer);
  let at = text.length;
  const put = (value, kind) => (view[`set${kind}`](at, value, true), (at += 8));
  bytes.set(text);
  put(BigInt(count), "BigUint64");
  for (const _ of names) for (const whole of [0, count]) put(BigInt(whole), "BigUint64"); // held, one for each row
  for (const begin of begins) put(begin, "Float64");
  for (const name of names) {
    const [factor, zero] = columns[name];
    for (const segment of segments) put(segment[name] / factor + zero, "Float64");
  }
  put(BigInt(checksum(bytes.subarray(0, at))), "BigUint64");
  return bytes;
}
