// The ground: its height, its surface where it is uneven, and its grid.

const DENSE = 40; // pixels between lines that are not visible
const SPARSE = 420; // and that are drawn in full
const MOST_LINES = 80; // in each direction
const FAR = 1e4; // m: how far uneven ground goes on beyond its corners

class Ground {
  /**
   * @param {object | null} ground of a clip
   * @param {number} floor height where it is level, m
   * @param {Numbers | null} heights unpacked, (rows, columns) m
   */
  constructor(ground, floor, heights) {
    this.floor = floor;
    this.level = !ground;
    /** The x and the y of its corners, ascending, m. */
    this.corners = [[], []];
    if (ground?.x) {
      this.corners = [ground.x, []];
      this._z = (column) => ground.z[column];
    } else if (ground) {
      const [rows, columns] = heights.shape;
      const along = (count, axis) =>
        Array.from({ length: count }, (_, i) => ground.corner[axis] + i * ground.spacing);
      this.corners = [along(columns, 0), along(rows, 1)];
      this._z = (column, row) => heights.values[row * columns + column];
    }
  }

  /**
   * Return its height, m.
   * @param {number} x
   * @param {number} y
   */
  height(x, y) {
    if (this.level) return this.floor;
    const [i, u] = placeIn(this.corners[0], x);
    const last = this.corners[0].length - 1;
    if (!this.corners[1].length) {
      const next = this._z(Math.min(i + 1, last));
      return this._z(i) + u * (next - this._z(i));
    }
    const [j, v] = placeIn(this.corners[1], y);
    // The squares are cut from their first corner to the opposite one, as MuJoCo does.
    const first = this._z(i, j);
    const across = this._z(i + 1, j + 1);
    const beside = v >= u ? this._z(i, j + 1) : this._z(i + 1, j);
    return first + Math.max(u, v) * (beside - first) + Math.min(u, v) * (across - beside);
  }

  /** Return its surface, which is level beyond its corners. */
  geometry() {
    const [xs, ys] = this.corners.map((corners) => [
      (corners[0] ?? 0) - FAR,
      ...corners,
      (corners.at(-1) ?? 0) + FAR,
    ]);
    const points = new Float32Array(3 * xs.length * ys.length);
    let at = 0;
    for (const y of ys) for (const x of xs) points.set([x, y, this.height(x, y)], 3 * at++);
    const triangles = [];
    for (let j = 0; j + 1 < ys.length; j++)
      for (let i = 0; i + 1 < xs.length; i++) {
        const one = j * xs.length + i;
        const opposite = one + xs.length + 1;
        triangles.push(one, one + 1, opposite, one, opposite, opposite - 1);
      }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    geometry.setIndex(triangles);
    return geometry;
  }
}

/**
 * Return the interval of ascending corners that a value is in, and its share of it.
 * @param {number[]} corners
 * @param {number} value
 * @returns {[number, number]}
 */
function placeIn(corners, value) {
  let low = 0;
  let high = corners.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (corners[middle] <= value) low = middle;
    else high = middle;
  }
  const wide = corners[high] - corners[low];
  return [low, wide ? clamp((value - corners[low]) / wide, 0, 1) : 0];
}

/**
 * Return distances between lines, each a multiple of the one before, from a least one, m.
 * @param {number} least
 */
function gridSteps(least) {
  const power = Math.floor(Math.log10(least)) - 1;
  return Array.from({ length: 12 }, (_, i) => (i % 2 ? 5 : 1) * 10 ** (power + (i >> 1)))
    .filter((step) => step >= 0.999 * least)
    .slice(0, 4);
}

/**
 * Return the lines of the grid around a point, the finer the nearer the camera is.
 * @param {Ground} ground
 * @param {ArrayLike<number>} middle
 * @param {number} scale pixels a metre there
 * @param {number} radius how far the ground is drawn, m
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
        // Lines of the next step are drawn once, and stronger.
        const share = (line * step) / coarser;
        if (coarser && Math.abs(share - Math.round(share)) < 1e-6) continue;
        // A chord of the circle in which the ground is drawn.
        const half = Math.sqrt(Math.max(radius ** 2 - (line * step - middle[axis]) ** 2, 0));
        const [start, end] = [middle[1 - axis] - half, middle[1 - axis] + half];
        const bends = ground.corners[1 - axis].filter((corner) => corner > start && corner < end);
        const along = [start, ...bends, end];
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

const GROUND_VERTEX = `precision highp float;
in vec3 position;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
out vec3 place;

void main() {
  place = position;
  gl_Position = projectionMatrix * (viewMatrix * vec4(position, 1.0));
}
`;

const GROUND_FRAGMENT = `precision highp float;
in vec3 place;
out vec4 colour;
uniform vec3 haze;
uniform vec3 dark;
uniform vec3 centre;
uniform float reach;

void main() {
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  normal *= sign(normal.z);
  float slope = 1.0 - dot(normal, ${LIGHT}) / 0.81;
  float away = length(place - centre) / reach;
  float fade = clamp(1.0 - away * away, 0.0, 1.0);
  vec3 tone = slope > 0.0 ? mix(haze, dark, min(1.6 * slope, 1.0)) : haze * (1.0 - 0.12 * slope);
  colour = vec4(mix(haze, tone, fade), 1.0);
}
`;
