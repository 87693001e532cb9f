// The grid of the ground: lines that fade with distance and are coarser if the camera is far away.

const DENSE = 40; // pixels between lines at which they become invisible
const SPARSE = 420; // pixels between lines of full strength
const MOST_LINES = 80; // maximum lines in each direction

/**
 * Return four distances between lines, m, each a multiple of the previous, from a minimum.
 * @param {number} least
 */
function gridSteps(least) {
  const power = Math.floor(Math.log10(least)) - 1;
  return Array.from({ length: 12 }, (_, i) => (i % 2 ? 5 : 1) * 10 ** (power + (i >> 1)))
    .filter((step) => step >= 0.999 * least)
    .slice(0, 4);
}

/**
 * Return the lines of the grid around a point, finer if the camera is near.
 * @param {Ground} ground
 * @param {ArrayLike<number>} middle
 * @param {number} scale pixels per metre at that point
 * @param {number} radius radius of the drawn ground, m
 * @returns {{ends: number[], strengths: number[]}}
 */
function gridLines(ground, middle, scale, radius) {
  const ends = [];
  const strengths = [];
  const steps = gridSteps(DENSE / scale);
  steps.forEach((step, number) => {
    const coarser = steps[number + 1];
    const strength = Math.min(Math.log((step * scale) / DENSE) / Math.log(SPARSE / DENSE), 1);
    if (strength < 0.06) return;
    const lines = Math.min(Math.floor(radius / step), MOST_LINES);
    for (const axis of [0, 1]) {
      const nearest = Math.round(middle[axis] / step);
      for (let line = nearest - lines; line <= nearest + lines; line++) {
        // Leave out the lines that the coarser grid draws.
        const share = (line * step) / coarser;
        if (coarser && Math.abs(share - Math.round(share)) < 1e-6) continue;
        // The line is a chord of the circle of the drawn ground.
        const half = Math.sqrt(Math.max(radius ** 2 - (line * step - middle[axis]) ** 2, 0));
        const [start, end] = [middle[1 - axis] - half, middle[1 - axis] + half];
        const along = [start, ...ground.bends(axis, line * step, start, end), end];
        /** @param {number} place */
        const point = (place) => {
          const [x, y] = axis ? [place, line * step] : [line * step, place];
          return [x, y, ground.height(x, y)];
        };
        for (let i = 0; i + 1 < along.length; i++) {
          ends.push(...point(along[i]), ...point(along[i + 1]));
          strengths.push(strength);
        }
      }
    }
  });
  return { ends, strengths };
}

class Grid extends Ribbons {
  constructor() {
    super(1, { polygonOffset: true, polygonOffsetFactor: -2 });
    this.mesh.renderOrder = ORDER.grid;
  }

  /**
   * Show the lines around a point; small movements of the camera do not change them.
   * @param {Ground} ground
   * @param {ArrayLike<number>} middle
   * @param {number} scale pixels per metre at that point
   * @param {number} reach radius of the drawn ground, m
   */
  show(ground, middle, scale, reach) {
    this.fade(middle, reach);
    const moved = this.middle ? Math.hypot(...[0, 1].map((i) => this.middle[i] - middle[i])) : 0;
    const alike = this.ground === ground && Math.abs(this.reach / reach - 1) < 0.02;
    if (alike && moved < 0.08 * reach) return;
    Object.assign(this, { ground, middle: [...middle], reach });
    const { ends, strengths } = gridLines(ground, middle, scale, 1.1 * reach);
    this.set(ends, strengths);
  }
}
