// Figures: of an error, as orchestration/closed_loop/metrics.py computes them, and drawings over time. What is inside the
// axes of a drawing is in seconds and values and stretched, so that what is dragged in it is in seconds and values too.

const SMALLEST_SHOWN = 0.05; // µm; below it an error is printed as 0.0, so that a share of it means nothing
const MOST_GROUPS = 500; // of a line's points; the lowest and the highest of each are drawn
const MOST_MARKS = 150; // of a line; of more, every so manieth is drawn

/** Figures of an error history in µm, taken every `step` s; `within` in s (0: always, null: never within tolerance). */
export function errorFigures(error, step, tolerance) {
  const sorted = Float64Array.from(error, Math.abs).sort();
  const last = error.length - 1;
  const squares = error.reduce((sum, each) => sum + each * each, 0) - (error[0] ** 2 + error[last] ** 2) / 2;
  const [below, above] = [sorted[Math.floor(0.95 * last)], sorted[Math.ceil(0.95 * last)]];
  const p95 = below + ((0.95 * last) % 1) * (above - below);
  const outside = error.findLastIndex((each) => !(Math.abs(each) <= tolerance));
  return { largest: sorted[last], rms: Math.sqrt(squares / last), p95, within: outside === last ? null : (outside + 1) * step };
}

/** Share of the largest error that was removed, in words; empty where that means nothing. */
export function removed(before, after) {
  if (after === before || !(Math.min(before.largest, after.largest) > SMALLEST_SHOWN)) return "";
  const percent = 100 * (1 - after.largest / before.largest);
  return `${Math.abs(percent).toFixed(0)} % ${percent < 0 ? "worse" : "removed"}`;
}

const short = (number) => (Math.abs(number) < 1e-3 && number ? number.toExponential() : String(number));

/** A number with so many digits, without zeros at the end. */
export const digits = (value, count = 6) => short(Number(value.toPrecision(count)));

/** A time in s with its unit. */
export const lasting = (time) =>
  time < 60 ? `${digits(time, 3)} s` : time < 3600 ? `${digits(time / 60, 3)} min` : `${digits(time / 3600, 3)} h`;

/** A text as it stands in HTML and XML. */
export const escaped = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);

const ends = (values) => [Math.min(...values), Math.max(...values)];

/** Round numbers from `low` to `high`, some six of them. */
function ticks(low, high) {
  const power = 10 ** Math.floor(Math.log10((high - low) / 6));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= (high - low) / 6.001);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

/** Draw SVG over axes: `label` of the values, `stop` in s, `low` and `high`; `told` is for those who do not see it. */
export function draw(figure, { label, stop, low, high, told, keys = "" }, drawn) {
  const [unit, seconds] = stop > 3 * 3600 ? ["h", 3600] : ["min", 60];
  const rows = ticks(low, high).map((value) => `<svg y="${(100 * (high - value)) / (high - low)}%">
    <text dx="-.5em" dy=".35em" text-anchor="end">${digits(value)}</text><rect width="100%" height="1"/></svg>`);
  const columns = ticks(0, stop / seconds).map((time) =>
    `<text x="${(100 * seconds * time) / stop}%" y="100%" dy="1.3em" text-anchor="middle">${digits(time)}</text>`);
  figure.innerHTML = `<svg role="img" aria-label="${escaped(told)}">${rows.join("")}${columns.join("")}
    <text dx="-3.7em" dy="-.8em">${escaped(label)}</text><text x="100%" y="100%" dy="2.6em" text-anchor="end">time [${unit}]</text>
    <svg viewBox="0 ${-high} ${stop} ${high - low}" preserveAspectRatio="none"><g transform="scale(1 -1)">${drawn.join("")}</g></svg>
    </svg><figcaption>${keys}</figcaption>`;
}

/** Points of a line with values at every `step` s. */
function pointsOf(values, step) {
  const size = Math.ceil(values.length / MOST_GROUPS);
  return Array.from({ length: Math.ceil(values.length / size) }, (_, i) => {
    const group = values.subarray(i * size, (i + 1) * size);
    const kept = group[0] > group.at(-1) ? ends(group).reverse() : ends(group);
    return kept.map((value) => [i * size * step, value]);
  }).flat();
}

/**
 * Draw lines of `name`, `values`, and `marks`, pairs of time in s and value that are drawn as dots; `style` is the number
 * of a line's colour and dashes. `band` is half the height of the tolerance band, 0 where there is none.
 */
export function drawLines(figure, { heading, label, band, lines }, step) {
  const stop = step * (lines[0].values.length - 1);
  const drawn = [`<path class="band" d="M0 ${-band}H${stop}V${band}H0Z"/>`];
  const [keys, told, heights] = [[], [], band ? [-1.2 * band, 1.2 * band] : []];
  for (const { name, values, marks, style } of lines) {
    const [points, every] = [pointsOf(values, step), Math.ceil(marks.length / MOST_MARKS)];
    const dots = marks.filter(([time], i) => i % every === 0 && time <= stop);
    heights.push(...[...points, ...dots].map(([, value]) => value));
    const look = `style="stroke: var(--line-${style}); stroke-dasharray: var(--dash-${style})"`;
    drawn.push(`<path ${look} d="M${points.map(([time, value]) => `${time} ${value.toPrecision(6)}`).join("L")}"/>`);
    const d = `d="${dots.map(([time, value]) => `M${time} ${value}h0`).join("")}"`;
    if (dots.length) drawn.push(`<path class="dots" ${look} ${d}/><path class="within" ${d}/>`);
    keys.push(`<span><svg width="40" height="10" aria-hidden="true"><path ${look} d="M1 5H33"/></svg>${escaped(name)}</span>`);
    told.push(`${name} from ${ends(points.map(([, value]) => value)).map((each) => digits(each, 3)).join(" to ")}`);
  }
  const [low, high] = ends(heights);
  const pad = high - low < 1e-9 ? 1 : 0.04 * (high - low);
  const axes = { label, stop, low: low - pad, high: high + pad, keys: keys.join("") };
  draw(figure, { ...axes, told: `${heading}: ${label} over time; ${told.join(", ")}` }, drawn);
}
