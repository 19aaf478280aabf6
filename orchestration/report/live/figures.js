// The figures of an error, as orchestration/closed_loop/metrics.py computes them, and how numbers are written.

const SMALLEST_SHOWN = 0.05; // µm; below it an error is printed as 0.0, so that a share of it means nothing

/** Figures of an error history in m, taken every `step` s: in µm, and in s (0: always within, null: never). */
export function errorFigures(error, step, tolerance) {
  const sorted = Float64Array.from(error, Math.abs).sort();
  const last = error.length - 1;
  const outside = error.findLastIndex((each) => !(Math.abs(each) <= tolerance));
  const squares = error.reduce((sum, each) => sum + each * each, 0) - (error[0] ** 2 + error[last] ** 2) / 2;
  const [below, above] = [sorted[Math.floor(0.95 * last)], sorted[Math.ceil(0.95 * last)]];
  return {
    largest: 1e6 * sorted[last],
    rms: 1e6 * Math.sqrt(last ? squares / last : error[0] ** 2),
    p95: 1e6 * (below + ((0.95 * last) % 1) * (above - below)),
    within: outside === last ? null : (outside + 1) * step,
  };
}

/** Share of the largest error that was removed, in words; empty where that means nothing. */
export function removed(before, after) {
  if (!(before.largest > SMALLEST_SHOWN && after.largest > SMALLEST_SHOWN)) return "";
  const percent = 100 * (1 - after.largest / before.largest);
  return `${Math.abs(percent).toFixed(0)} % ${percent < 0 ? "worse" : "removed"}`;
}

/** From when on an error is within tolerance. */
export function since(within) {
  if (!within) return within === null ? "never" : "start";
  const [unit, seconds] = within >= 3600 ? ["h", 3600] : within >= 60 ? ["min", 60] : ["s", 1];
  return `${digits(within / seconds, 3)} ${unit}`;
}

/** A number with so many digits, without zeros at the end. */
export function digits(value, count = 6) {
  const rounded = Number(value.toPrecision(count));
  return Math.abs(rounded) < 1e-3 && rounded ? rounded.toExponential() : String(rounded);
}
