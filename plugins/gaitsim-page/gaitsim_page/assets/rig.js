// A body as a tree of links placed by joint angles, computed as in gaitsim/contracts/rig.py.

/**
 * Rotate a point by a quaternion.
 * @param {ArrayLike<number>} turn w, x, y, z
 * @param {ArrayLike<number>} point
 * @returns {[number, number, number]}
 */
function rotated(turn, point) {
  const [w, x, y, z] = [turn[0], turn[1], turn[2], turn[3]];
  const [px, py, pz] = [point[0], point[1], point[2]];
  const [tx, ty, tz] = [2 * (y * pz - z * py), 2 * (z * px - x * pz), 2 * (x * py - y * px)];
  return [
    px + w * tx + y * tz - z * ty,
    py + w * ty + z * tx - x * tz,
    pz + w * tz + x * ty - y * tx,
  ];
}

/** Return the rotation `other` followed by `one`. */
function product(one, other) {
  const [a, b, c, d] = one;
  const [w, x, y, z] = other;
  return [
    a * w - b * x - c * y - d * z,
    a * x + b * w + c * z - d * y,
    a * y - b * z + c * w + d * x,
    a * z + b * y - c * x + d * w,
  ];
}

const NUDGE = 1e-5; // m: on a line between two feet, all triangles with this side are equally high

/**
 * Return the rotation that lays the feet on which a body rests on the ground: the lowest triangle of
 * feet under the trunk's middle, as in plugins/gaitsim_spider/walking.py.
 * @param {number[][]} soles
 */
function resting(soles) {
  const feet = soles.map(([x, y, z]) => [x - NUDGE, y - NUDGE, z]);
  const area = (one, other) => one[0] * other[1] - one[1] * other[0];
  let lowest = Infinity;
  let turn = [1, 0, 0, 0];
  feet.forEach((a, i) =>
    feet.slice(i + 1).forEach((b, j) =>
      feet.slice(i + j + 2).forEach((c) => {
        const shares = [area(b, c), area(c, a), area(a, b)];
        if (Math.min(...shares) < 0 && Math.max(...shares) > 0) return;
        const whole = shares[0] + shares[1] + shares[2];
        const height = (shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2]) / whole;
        if (!(height < lowest)) return;
        lowest = height;
        const [u, v] = [b, c].map((foot) => foot.map((value, axis) => value - a[axis]));
        // The area of the triangle seen from above is `whole`, so the normal is (nx, ny, 1).
        const nx = (u[1] * v[2] - u[2] * v[1]) / whole;
        const ny = (u[2] * v[0] - u[0] * v[2]) / whole;
        const size = Math.hypot(nx, ny, 1);
        const long = Math.hypot(1 + size, nx, ny);
        turn = [(1 + size) / long, ny / long, -nx / long, 0];
      }),
    ),
  );
  return turn;
}

/**
 * Return how far a box reaches below its middle, m.
 * @param {ArrayLike<number>} turn w, x, y, z
 * @param {ArrayLike<number>} half half lengths, m
 */
function depthOf([w, x, y, z], [a, b, c]) {
  const sides = [2 * a * (x * z - w * y), 2 * b * (y * z + w * x), c * (1 - 2 * (x * x + y * y))];
  return sides.reduce((sum, side) => sum + Math.abs(side), 0);
}

class Rig {
  /** @param {object} body body in the page's data, see atlas.py */
  constructor(body) {
    this.body = body;
    this.count = body.clip.ends.length ? Math.max(...body.clip.ends) + 1 : 0;
    // Maximum height of feet on the ground, m.
    this.near = (body.rests ? 0.004 : 0.01) * body.clip.span;
    const { solids } = body.clip;
    // A body of boxes alone, such as a creature, touches the ground with any of them.
    this.boxes = solids.length > 0 && solids.every(({ shape }) => shape === "box");
  }

  /**
   * Place the body at joint angles, with its lowest foot on the ground and its trunk above 0. A
   * body that rests on its feet leans; others are level. A body of boxes lies on the lowest corner.
   * @param {ArrayLike<number>} angles rad
   * @param {number} lost index of a foot on which the body does not rest
   * @returns {object} a pose for gaitsim.Body
   */
  place(angles, lost = -1) {
    const { links, segments, solids, feet, clip, stand } = this.body;
    const places = [];
    const turns = [];
    for (const { parent, origin, rotation, joint, axis } of links) {
      let [place, turn] = [origin, rotation];
      if (parent >= 0) {
        const moved = rotated(turns[parent], origin);
        place = moved.map((value, i) => value + places[parent][i]);
        turn = product(turns[parent], rotation);
      }
      if (joint >= 0) {
        const sine = Math.sin(angles[joint] / 2);
        const about = axis.map((share) => sine * share);
        turn = product(turn, [Math.cos(angles[joint] / 2), ...about]);
      }
      places.push(place);
      turns.push(turn);
    }
    const at = (link, point) =>
      rotated(turns[link], point).map((value, i) => value + places[link][i]);
    const kept = feet.filter((_, foot) => foot !== lost);
    if (this.body.rests) {
      const lean = resting(kept.map(([link, point]) => at(link, point)));
      places.forEach((place, link) => {
        places[link] = rotated(lean, place);
        turns[link] = product(lean, turns[link]);
      });
    }
    const soles = feet.map(([link, point]) => at(link, point));
    const ends = segments.flatMap(([link, one, other]) => [at(link, one), at(link, other)]);
    const lowest = kept.length ? kept.map(([link, point]) => at(link, point)) : ends;
    const low = Math.min(...lowest.map(([, , z]) => z));
    const placed = solids.map(([link, pose]) => [
      at(link, pose),
      product(turns[link], pose.slice(3)),
    ]);
    const bottom = ([[, , z], turn], i) => z - depthOf(turn, clip.solids[i].size);
    const up = this.boxes ? -Math.min(...placed.map(bottom)) : stand - low;
    const points = new Float64Array(3 * this.count);
    if (this.count)
      ends.forEach(([x, y, z], end) => points.set([x, y, z + up], 3 * clip.ends[end]));
    const poses = placed.flatMap(([[x, y, z], turn]) => [x, y, z + up, ...turn]);
    return {
      points,
      poses,
      feet: soles.flatMap(([x, y, z]) => [x, y, z + up]),
      touching: soles.map(([, , z]) => (z - low < this.near ? 1 : 0)),
      centre: [0, 0, places[0][2] + up],
    };
  }
}
