// The figures of an error, as orchestration/closed_loop/metrics.py computes them, and how they are written.

const SMALLEST_SHOWN = 0.05; // um; below it an error is printed as 0.0, so that a share of it means nothing

/** Figures of an error history in m, taken every `step` s: in um, and in s (0: always within, null: never). */
export function errorFigures(error, step, tolerance) {
  const size = error.map(Math.abs);
  const last = size.length - 1;
  const outside = size.findLastIndex((each) => !(each <= tolerance));
  const squares = error.reduce((sum, each) => sum + each * each, 0) - (error[0] ** 2 + error[last] ** 2) / 2;
  const sorted = Float64Array.from(size).sort();
  const place = 0.95 * last;
  const below = sorted[Math.floor(place)];
  return {
    largest: 1e6 * sorted[last],
    rms: 1e6 * Math.sqrt(last ? squares / last : error[0] ** 2),
    p95: 1e6 * (below + (place % 1) * (sorted[Math.ceil(place)] - below)),
    within: outside === last ? null : (outside + 1) * step,
  };
}

/** Share in percent of the largest error that was removed; null where that means nothing. */
export function removed(before, after) {
  if (!(before.largest > SMALLEST_SHOWN && after.largest > SMALLEST_SHOWN)) return null;
  return 100 * (1 - after.largest / before.largest);
}

/** A number with so many digits, without zeros at the end. */
export function digits(value, count = 6) {
  const rounded = Number(value.toPrecision(count));
  return Math.abs(rounded) < 1e-3 && rounded ? rounded.toExponential() : String(rounded);
}

export function duration(seconds) {
  if (seconds >= 3600) return `${digits(seconds / 3600, 3)} h`;
  return seconds >= 60 ? `${digits(seconds / 60, 3)} min` : `${digits(seconds, 3)} s`;
}

export function since(within) {
  return within === null ? "never" : within === 0 ? "start" : duration(within);
}
