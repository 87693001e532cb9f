// The ground: its height, and the surface of uneven ground.

class Ground {
  /**
   * @param {object | null} ground ground of a clip; null for level ground
   * @param {number} floor height of level ground, m
   * @param {Numbers | null} heights unpacked heights of a terrain, (rows, columns) m
   */
  constructor(ground, floor, heights) {
    this.floor = floor;
    this.level = !ground;
    /** Ascending x and y of the corners, m. */
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
   * Return the height of the ground, m.
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
    // Squares are cut along the diagonal from their first corner, as in MuJoCo.
    const first = this._z(i, j);
    const across = this._z(i + 1, j + 1);
    const beside = v >= u ? this._z(i, j + 1) : this._z(i + 1, j);
    return first + Math.max(u, v) * (beside - first) + Math.min(u, v) * (across - beside);
  }

  /**
   * Return the surface within a distance of a point; beyond its corners the ground is level.
   * @param {ArrayLike<number>} middle
   * @param {number} reach m
   */
  surface(middle, reach) {
    // Only the visible part, as the depths of very large triangles are inexact.
    const [xs, ys] = this.corners.map((corners, axis) => {
      const [low, high] = [middle[axis] - reach, middle[axis] + reach];
      return [Math.min(corners[0] ?? low, low), ...corners, Math.max(corners.at(-1) ?? high, high)];
    });
    const points = [];
    const slopes = [];
    for (let j = 0; j + 1 < ys.length; j++) {
      const away = Math.max(ys[j] - middle[1], middle[1] - ys[j + 1], 0);
      const half = Math.sqrt(Math.max(reach ** 2 - away ** 2, 0));
      for (let i = 0; half && i + 1 < xs.length; i++) {
        if (xs[i + 1] < middle[0] - half || xs[i] > middle[0] + half) continue;
        const at = (x, y) => [x, y, this.height(x, y)];
        const [one, other] = [at(xs[i], ys[j]), at(xs[i + 1], ys[j + 1])];
        const [right, left] = [at(xs[i + 1], ys[j]), at(xs[i], ys[j + 1])];
        for (const triangle of [[one, right, other], [one, other, left]]) {
          const normal = normalOf(triangle.flat(), [0, 1, 2]);
          // 0 for level ground, 1 for grazing light, negative for slopes that face the light.
          const slope = 1 - (0.3 * normal[0] - 0.5 * normal[1] + 0.81 * normal[2]) / 0.81;
          points.push(...triangle.flat());
          slopes.push(slope, slope, slope);
        }
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    geometry.setAttribute("slope", new THREE.BufferAttribute(new Float32Array(slopes), 1));
    return geometry;
  }

  /**
   * Return where a line of the grid bends: at corners, and where it crosses the cut of a square.
   * @param {number} axis axis perpendicular to the line
   * @param {number} place position of the line on that axis, m
   * @param {number} start start of the line along the other axis, m
   * @param {number} end end of the line, m
   */
  bends(axis, place, start, end) {
    const own = this.corners[1 - axis];
    const inside = (value) => value > start && value < end;
    const corners = own.filter(inside);
    if (!this.corners[axis].length || !own.length) return corners;
    const share = placeIn(this.corners[axis], place)[1];
    const cuts = own.slice(0, -1).map((corner, i) => corner + share * (own[i + 1] - corner));
    return [...new Set([...corners, ...cuts.filter(inside)])].sort((a, b) => a - b);
  }
}

/**
 * Return the index of the interval between corners that contains a value, and its share of it.
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

const GROUND_VERTEX = `precision highp float;
in vec3 position;
in float slope;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
uniform vec3 haze;
uniform vec3 dark;
uniform vec3 centre;
uniform float reach;
out vec3 tone;
out vec2 away;

void main() {
  away = (position.xy - centre.xy) / reach;
  tone = slope > 0.0 ? mix(haze, dark, min(1.6 * slope, 1.0)) : haze * (1.0 - 0.12 * slope);
  gl_Position = projectionMatrix * (viewMatrix * vec4(position, 1.0));
}
`;

const GROUND_FRAGMENT = `precision highp float;
in vec3 tone;
in vec2 away;
out vec4 colour;
uniform vec3 haze;

void main() {
  colour = vec4(mix(tone, haze, min(dot(away, away), 1.0)), 1.0);
}
`;
