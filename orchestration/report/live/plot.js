// Drawings over time. Their SVG is in seconds and values, and stretched over its figure, so that what is dragged in it is
// in seconds and values too; the texts at its axes are HTML.

import { digits } from "./figures.js";

const MOST_GROUPS = 500; // of a line's points; the lowest and the highest of each are drawn
const DASHES = ["", "8 4", "2 3", "10 3 2 3", "14 4", "14 3 2 3 2 3"];

const escaped = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);

function extent(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

/** Round numbers from `low` to `high`, some six of them. */
function ticks(low, high) {
  const power = 10 ** Math.floor(Math.log10((high - low) / 6));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= (high - low) / 6.001);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

/** Draw SVG over axes: `label` of the values, `stop` in s, `low` and `high`; `told` is for those who do not see it. */
export function draw(figure, { label, stop, low, high }, told, drawn) {
  const [unit, seconds] = stop > 3 * 3600 ? ["h", 3600] : ["min", 60];
  const rows = ticks(low, high);
  const texts = [
    ...rows.map((value) => `<span style="top: ${(100 * (high - value)) / (high - low)}%">${digits(value)}</span>`),
    ...ticks(0, stop / seconds).map((time) => `<b style="left: ${(100 * seconds * time) / stop}%">${digits(time)}</b>`),
  ];
  const grid = rows.map((value) => `<path class="grid" d="M0 ${value}H${stop}"/>`);
  figure.querySelector(".frame").innerHTML = `<i>${escaped(label)}</i><i>time [${unit}]</i>${texts.join("")}
    <svg role="img" aria-label="${escaped(told)}" viewBox="0 ${-high} ${stop} ${high - low}" preserveAspectRatio="none">
    <g transform="scale(1 -1)">${[...grid, ...drawn].join("")}</g></svg>`;
}

/** Path through values at every `step` s. */
function path(values, step) {
  const size = Math.ceil(values.length / MOST_GROUPS);
  const points = [];
  for (let first = 0; first < values.length; first += size) {
    const group = values.subarray(first, first + size);
    const [low, high] = extent(group);
    const kept = low === high ? [low] : group[0] > group.at(-1) ? [high, low] : [low, high];
    points.push(...kept.map((value) => `${first * step} ${value.toPrecision(6)}`));
  }
  return `M${points.join("L")}`;
}

/**
 * Draw lines, and a legend. `lines` have a name, values, and perhaps a style (a number, by which colour and dashes go) and
 * `marks`, pairs of time in s and value that are drawn as dots. `band` is half the height of the tolerance band.
 */
export function drawLines(figure, { heading, label, step, lines, band = 0 }) {
  const stop = step * (lines[0].values.length - 1);
  const marked = lines.flatMap(({ marks = [] }) => marks.map(([, value]) => value));
  const ends = lines.map(({ values }) => extent(values));
  const [low, high] = extent([...ends.flat(), ...marked, ...(band ? [-1.2 * band, 1.2 * band] : [])]);
  const pad = high - low < 1e-9 ? 1 : 0.04 * (high - low);
  const drawn = [`<path class="band" d="M0 ${-band}H${stop}V${band}H0Z"/>`];
  const keys = lines.map(({ name, values, marks = [], style }, i) => {
    const number = (style ?? i) % DASHES.length;
    const look = `style="stroke: var(--line-${number})"`;
    const dashed = `${look} stroke-dasharray="${DASHES[number]}"`;
    const dots = marks.map(([time, value]) => `M${time} ${value}h0`).join("");
    drawn.push(`<path ${dashed} d="${path(values, step)}"/>`);
    if (dots) drawn.push(`<path class="dots" ${look} d="${dots}"/><path class="within" d="${dots}"/>`);
    return `<span><svg width="34" height="10" aria-hidden="true"><path ${dashed} d="M1 5H33"/></svg>${escaped(name)}</span>`;
  });
  const told = lines.map(({ name }, i) => `${name} from ${ends[i].map((each) => digits(each, 3)).join(" to ")}`);
  draw(figure, { label, stop, low: low - pad, high: high + pad }, `${heading}: ${label} over time; ${told.join(", ")}`, drawn);
  figure.querySelector("figcaption").innerHTML = keys.join("");
}
