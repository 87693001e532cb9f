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

class Rig {
  /** @param {object} body body in the page's data, see atlas.py */
  constructor(body) {
    this.body = body;
    this.count = body.clip.ends.length ? Math.max(...body.clip.ends) + 1 : 0;
    this.near = 0.01 * body.clip.span; // maximum height of feet on the ground, m
  }

  /**
   * Place the body at joint angles, with its lowest foot on the ground and its trunk above 0.
   * @param {ArrayLike<number>} angles rad
   * @returns {object} a pose for gaitsim.Body
   */
  place(angles) {
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
    const soles = feet.map(([link, point]) => at(link, point));
    const ends = segments.flatMap(([link, one, other]) => [at(link, one), at(link, other)]);
    const low = Math.min(...(soles.length ? soles : ends).map(([, , z]) => z));
    const up = stand - low;
    const points = new Float64Array(3 * this.count);
    if (this.count)
      ends.forEach(([x, y, z], end) => points.set([x, y, z + up], 3 * clip.ends[end]));
    const poses = solids.flatMap(([link, pose]) => {
      const [x, y, z] = at(link, pose);
      return [x, y, z + up, ...product(turns[link], pose.slice(3))];
    });
    return {
      points,
      poses,
      feet: soles.flatMap(([x, y, z]) => [x, y, z + up]),
      touching: soles.map(([, , z]) => (z - low < this.near ? 1 : 0)),
      centre: [0, 0, places[0][2] + up],
    };
  }
}
