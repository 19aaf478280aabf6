// A small plot of lines over time, as SVG.

import { element } from "./dom.js";
import { digits } from "./figures.js";

const MARGIN = { left: 52, right: 14, top: 12, bottom: 38, text: 20 };
const HEIGHT = 260;
const DASHES = ["", "8 4", "2 3", "10 3 2 3", "14 4", "14 3 2 3 2 3"];

const escaped = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);

/** Round numbers from `low` to `high`, about `count` of them. */
function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

/**
 * The frame of a drawing over time in a figure: places `x` of times in s and `y` of values, the texts at its axes, and `svg`,
 * which puts what is drawn between them into the figure. `values` are the lowest, the highest, and about how many texts.
 */
export function frame(figure, height, edge, stop, [low, high, count]) {
  const width = Math.max(figure.clientWidth, 280);
  const [wide, tall] = [width - edge.left - edge.right, height - edge.top - edge.bottom];
  const [unit, seconds] = stop > 3 * 3600 ? ["h", 3600] : ["min", 60];
  const x = (time) => edge.left + (time / stop) * wide;
  const y = (value) => edge.top + ((high - value) / (high - low)) * tall;
  const rows = ticks(low, high, count).map((value) => [y(value), digits(value)]);
  const across = rows.map(([at, text]) => `<text x="${edge.left - 6}" y="${at + 4}" text-anchor="end">${text}</text>`);
  const along = ticks(0, stop / seconds, width > 500 ? 8 : 4).map(
    (time) => `<text x="${x(time * seconds)}" y="${height - edge.text}" text-anchor="middle">${digits(time)}</text>`,
  );
  const svg = (label, ...drawn) => {
    figure.querySelector("svg")?.remove();
    figure.insertAdjacentHTML("afterbegin", `<svg role="img" viewBox="0 0 ${width} ${height}" width="${width}" height="${height}" ` +
      `aria-label="${escaped(label)}">${[...across, ...along, ...drawn].join("")}</svg>`);
  };
  return { x, y, rows, unit, svg, width, scale: { time: stop / wide, value: (high - low) / tall } };
}

/** Points of a line, no more than two for a pixel: its lowest and its highest value there. */
function points(values, x, y, width) {
  const group = Math.max(1, Math.floor(values.length / width));
  const kept = [];
  for (let first = 0; first < values.length; first += group) {
    const last = Math.min(first + group, values.length);
    let [low, high] = [first, first];
    for (let i = first; i < last; i++) {
      if (values[i] < values[low]) low = i;
      if (values[i] > values[high]) high = i;
    }
    kept.push(...(low === high ? [low] : low < high ? [low, high] : [high, low]));
  }
  return kept.map((i) => `${x(i).toFixed(1)},${y(values[i]).toFixed(1)}`).join(" ");
}

/**
 * Draw lines into a figure.
 *
 * `plot` has `heading`, `label` (of the vertical axis), `step` in s, and `lines`: name, values, style (a number, by which
 * colour and dashes go), and perhaps `marks`, pairs of time in s and value that are drawn as dots. `band` is half the
 * height of the tolerance band.
 */
export function drawPlot(figure, { heading, label, step, lines, band }) {
  const stop = step * (lines[0].values.length - 1);
  const shown = lines.flatMap(({ values, marks = [] }) => [extent(values), extent(marks.map(([, value]) => value))]);
  const ends = [...shown.flat().filter(Number.isFinite), ...(band ? [-1.2 * band, 1.2 * band] : [])];
  let [low, high] = extent(ends);
  if (high - low < 1e-9) [low, high] = [low - 1, high + 1];
  const pad = 0.04 * (high - low);
  const { x, y, rows, unit, svg, width } = frame(figure, HEIGHT, MARGIN, stop, [low - pad, high + pad, 5]);
  const right = width - MARGIN.right;
  const grid = rows.map(([at]) => `<line class="grid" x1="${MARGIN.left}" x2="${right}" y1="${at}" y2="${at}"/>`);
  const tolerance = band
    ? `<rect class="band" x="${MARGIN.left}" width="${right - MARGIN.left}" y="${y(band)}" height="${y(-band) - y(band)}"/>`
    : "";
  const drawn = lines.map(({ values, marks = [], style }) =>
    `<polyline class="line line-${style}" stroke-dasharray="${DASHES[style]}" points="${points(values, (i) => x(i * step), y, width)}"/>` +
    marks.map(([time, value]) => `<circle class="mark line-${style}" cx="${x(time).toFixed(1)}" cy="${y(value).toFixed(1)}" r="3"/>`).join(""),
  );
  const told = lines.map(({ name, values }) => `${name} from ${extent(values).map((each) => digits(each, 3)).join(" to ")}`);
  svg(`${heading}: ${label} over time; ${told.join(", ")}`, tolerance, ...grid, ...drawn,
    `<text x="${(MARGIN.left + width) / 2}" y="${HEIGHT - 4}" text-anchor="middle">time [${unit}]</text>`,
    `<text transform="translate(12 ${HEIGHT / 2 - 10}) rotate(-90)" text-anchor="middle">${escaped(label)}</text>`);
  const keys = lines.map(({ name, style }) => `<span><svg width="34" height="10" aria-hidden="true"><line class="line line-${style}" ` +
    `stroke-dasharray="${DASHES[style]}" x1="1" x2="33" y1="5" y2="5"/></svg>${escaped(name)}</span>`);
  const legend = figure.querySelector("figcaption") ?? figure.appendChild(element("figcaption"));
  legend.innerHTML = keys.join("");
}

export function extent(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}
