// Arithmetic on points and colours.

/** @typedef {[number, number, number]} Point metres; x forward, y left, z up */

/**
 * Clip a value to an interval.
 * @param {number} value
 * @param {number} low
 * @param {number} high
 */
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

/**
 * Return the red, green and blue of '#rrggbb', 0 to 1 each.
 * @param {string} colour
 * @returns {Point}
 */
function rgb(colour) {
  const value = parseInt(colour.slice(1), 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

/**
 * Mix two colours or points.
 * @param {Point} one
 * @param {Point} other
 * @param {number} share share of the other
 * @returns {Point}
 */
const mix = (one, other, share) =>
  /** @type {Point} */ (one.map((value, axis) => value + share * (other[axis] - value)));

const BLACK = /** @type {Point} */ ([0, 0, 0]);
const WHITE = /** @type {Point} */ ([1, 1, 1]);

/**
 * Smooth a path with a Gaussian in time, for the camera to follow.
 * @param {Float64Array} path (frames, 3)
 * @param {number} frameRate Hz
 * @param {number} seconds standard deviation
 * @returns {Float64Array}
 */
function smoothPath(path, frameRate, seconds = 0.2) {
  const frames = path.length / 3;
  const sigma = seconds * frameRate;
  const half = Math.min(Math.floor(3 * sigma), frames - 1);
  if (half < 1) return path;
  const weights = Array.from({ length: 2 * half + 1 }, (_, i) =>
    Math.exp(-0.5 * ((i - half) / sigma) ** 2),
  );
  const whole = weights.reduce((sum, weight) => sum + weight, 0);
  const smooth = new Float64Array(path.length);
  const last = frames - 1;
  for (let frame = 0; frame < frames; frame++)
    for (let axis = 0; axis < 3; axis++) {
      let sum = 0;
      for (let i = -half; i <= half; i++) {
        // The ends are mirrored, so that a steady walk remains steady.
        const at = frame + i;
        const end = at < 0 ? 0 : last;
        const value =
          at < 0 || at > last
            ? 2 * path[3 * end + axis] - path[3 * (2 * end - at) + axis]
            : path[3 * at + axis];
        sum += weights[i + half] * value;
      }
      smooth[3 * frame + axis] = sum / whole;
    }
  return smooth;
}

/** A box that grows around points. */
class Box {
  constructor() {
    this.low = [Infinity, Infinity, Infinity];
    this.high = [-Infinity, -Infinity, -Infinity];
  }

  /**
   * Extend the box to contain a ball.
   * @param {number} x
   * @param {number} y
   * @param {number} z
   * @param {number} radius
   */
  add(x, y, z, radius = 0) {
    [x, y, z].forEach((value, axis) => {
      this.low[axis] = Math.min(this.low[axis], value - radius);
      this.high[axis] = Math.max(this.high[axis], value + radius);
    });
    return this;
  }

  /** Lengths along the axes, m. */
  get size() {
    return this.high.map((value, axis) => value - this.low[axis]);
  }

  /** Middle of the box. */
  get middle() {
    return /** @type {Point} */ (this.high.map((value, axis) => (value + this.low[axis]) / 2));
  }
}
