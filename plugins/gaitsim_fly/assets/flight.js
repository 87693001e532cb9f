"use strict";

// Flight of one fly: the operations of `flight.py` and `mechanics.py`. Numbers are doubles in
// JavaScript too, with the same rounding, so a page reproduces Python's flights exactly.

/** @typedef {[number, number, number]} Vector */
/** @typedef {[number, number, number, number]} Quaternion w, x, y, z */

/**
 * Body, wings and air of a fly, in SI units.
 * @typedef {Object} Mechanics
 * @property {number} inverseMass
 * @property {Vector} inverseInertia - inverse principal moments of inertia
 * @property {Vector} faces - ½ ρ C_D A of the body's faces normal to its axes
 * @property {number} wing - ½ ρ C_D A of a wing
 * @property {number} hinge - distance of the hinges from the centre of mass
 * @property {number} arm - distance of a wing's centroid from its hinge
 * @property {number} wingSpeed - largest angular speed of a wing
 * @property {number} gravity - acceleration of gravity
 * @property {[number, number]} wind - velocity of the air along x and y
 */

/**
 * The state of a flight in the world frame: x forward, y left, z up.
 * @typedef {Object} State
 * @property {Vector} position
 * @property {Quaternion} rotation
 * @property {Vector} velocity
 * @property {Vector} momentum - angular momentum about the centre of mass
 * @property {number[]} wings - flap, pitch and sweep of the left wing, then of the right wing
 * @property {number[]} rates - rates of those six angles
 * @property {boolean} alive - false once the flight is unstable
 */

const FASTEST = 300.0; // m/s, speed above which a flight counts as unstable
const LARGEST_TURN = 0.5; // rad per step, above which the midpoint rule is inaccurate

// Taylor coefficients.
const S3 = -1 / 6, S5 = 1 / 120, S7 = -1 / 5040, S9 = 1 / 362880;
const S11 = -1 / 39916800, S13 = 1 / 6227020800, S15 = -1 / 1307674368000;
const C4 = 1 / 24, C6 = -1 / 720, C8 = 1 / 40320, C10 = -1 / 3628800;
const C12 = 1 / 479001600, C14 = -1 / 87178291200, C16 = 1 / 20922789888000;

/** Return the sine to 1e-11 for |x| ≤ π/2, with the same digits in every browser. */
function sine(x) {
  const y = x * x;
  const high = S9 + y * (S11 + y * (S13 + y * S15));
  return x * (1.0 + y * (S3 + y * (S5 + y * (S7 + y * high))));
}

/** Return the cosine for |x| ≤ π/2, like `sine`. */
function cosine(x) {
  const y = x * x;
  const high = C10 + y * (C12 + y * (C14 + y * C16));
  return 1.0 + y * (-0.5 + y * (C4 + y * (C6 + y * (C8 + y * high))));
}

/** Return a wing's direction, normal and rate of direction in the body's frame, nine numbers. */
function wing(flap, pitch, sweep, flapping, sweeping, side) {
  const sf = sine(flap), cf = cosine(flap);
  const sp = sine(pitch), cp = cosine(pitch);
  const ss = sine(sweep), cs = cosine(sweep);
  return [
    ss,
    side * (cs * cf),
    cs * sf,
    -sp * cs,
    side * (sp * ss * cf - cp * sf),
    sp * ss * sf + cp * cf,
    cs * sweeping,
    -side * (ss * cf * sweeping + cs * sf * flapping),
    cs * cf * flapping - ss * sf * sweeping,
  ];
}

/** Return the rotation matrix of a unit quaternion, row by row, nine numbers. */
function rotationMatrix([w, x, y, z]) {
  return [
    1.0 - 2.0 * (y * y + z * z),
    2.0 * (x * y - w * z),
    2.0 * (x * z + w * y),
    2.0 * (x * y + w * z),
    1.0 - 2.0 * (x * x + z * z),
    2.0 * (y * z - w * x),
    2.0 * (x * z - w * y),
    2.0 * (y * z + w * x),
    1.0 - 2.0 * (x * x + y * y),
  ];
}

/** Rotate a vector from the body's frame to the world frame. */
function toWorld(r, x, y, z) {
  return [
    r[0] * x + r[1] * y + r[2] * z,
    r[3] * x + r[4] * y + r[5] * z,
    r[6] * x + r[7] * y + r[8] * z,
  ];
}

/** Return the angular velocity R I⁻¹ Rᵀ L of an angular momentum L, both in the world frame. */
function spinOf(r, momentum, inverse) {
  const [lx, ly, lz] = momentum;
  return toWorld(
    r,
    (r[0] * lx + r[3] * ly + r[6] * lz) * inverse[0],
    (r[1] * lx + r[4] * ly + r[7] * lz) * inverse[1],
    (r[2] * lx + r[5] * ly + r[8] * lz) * inverse[2],
  );
}

/**
 * Return the force on a wing and its moment about the centre of mass, in the world frame.
 * F_axis = −½ ρ C_D A_axis |v| v_axis, where A_axis = A |n_axis| and C_D is proportional to
 * |cos(n, v)|.
 */
function wingLoad(r, v, s, angles, rates, from, side, own) {
  const d = wing(
    angles[from], angles[from + 1], angles[from + 2], rates[from], rates[from + 2], side);
  const arm = own.arm;
  const [ax, ay, az] = toWorld(r, arm * d[0], side * own.hinge + arm * d[1], arm * d[2]);
  const [nx, ny, nz] = toWorld(r, d[3], d[4], d[5]);
  const [ux, uy, uz] = toWorld(r, arm * d[6], arm * d[7], arm * d[8]);
  const vx = v[0] + (s[1] * az - s[2] * ay) + ux;
  const vy = v[1] + (s[2] * ax - s[0] * az) + uy;
  const vz = v[2] + (s[0] * ay - s[1] * ax) + uz;
  const k = -own.wing * Math.abs(nx * vx + ny * vy + nz * vz);
  const fx = k * Math.abs(nx) * vx, fy = k * Math.abs(ny) * vy, fz = k * Math.abs(nz) * vz;
  return [fx, fy, fz, ay * fz - az * fy, az * fx - ax * fz, ax * fy - ay * fx];
}

/** Return acceleration, torque and spin in the world frame. */
function load(rotation, velocity, momentum, angles, rates, own) {
  const r = rotationMatrix(rotation);
  const s = spinOf(r, momentum, own.inverseInertia);
  const v = [velocity[0] - own.wind[0], velocity[1] - own.wind[1], velocity[2]];
  const a = wingLoad(r, v, s, angles, rates, 0, 1.0, own);
  const b = wingLoad(r, v, s, angles, rates, 3, -1.0, own);
  const speed = Math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const [fx, fy, fz] = own.faces;
  const shadow = (row) => // the cuboid's area projected on an axis, times ½ ρ C_D
    Math.abs(r[row]) * fx + Math.abs(r[row + 1]) * fy + Math.abs(r[row + 2]) * fz;
  return {
    acceleration: [
      ((a[0] + b[0]) - shadow(0) * speed * v[0]) * own.inverseMass,
      ((a[1] + b[1]) - shadow(3) * speed * v[1]) * own.inverseMass,
      ((a[2] + b[2]) - shadow(6) * speed * v[2]) * own.inverseMass - own.gravity,
    ],
    torque: [a[3] + b[3], a[4] + b[4], a[5] + b[5]],
    spin: s,
  };
}

/** Rotate a unit quaternion for `dt` by a spin s in the world frame: exp(½ dt s) q. */
function rotateQuaternion(q, spin, dt) {
  let x = 0.5 * dt * spin[0], y = 0.5 * dt * spin[1], z = 0.5 * dt * spin[2];
  const h = x * x + y * y + z * z;
  const w = 1.0 + h * (-0.5 + h * (C4 + h * C6));
  const k = 1.0 + h * (S3 + h * (S5 + h * S7));
  x = k * x;
  y = k * y;
  z = k * z;
  const a = w * q[0] - (x * q[1] + y * q[2] + z * q[3]);
  const b = w * q[1] + x * q[0] + (y * q[3] - z * q[2]);
  const c = w * q[2] + y * q[0] + (z * q[1] - x * q[3]);
  const d = w * q[3] + z * q[0] + (x * q[2] - y * q[1]);
  const n = 1.0 / Math.sqrt(a * a + b * b + c * c + d * d);
  return [a * n, b * n, c * n, d * n];
}

/** Return a vector after `dt` at a constant rate. */
function extrapolate(vector, rate, dt) {
  return vector.map((number, i) => number + dt * rate[i]);
}

const squared = (v) => v[0] * v[0] + v[1] * v[1] + v[2] * v[2];

/**
 * Advance a flight with the midpoint rule while the wings turn at constant rates. A body that
 * would turn or move too fast for the step keeps its state, and `alive` becomes false.
 * @param {State} state - advanced in place
 * @param {number} dt - time step, s
 * @param {number} steps - number of steps
 * @param {Mechanics} own
 */
function step(state, dt, steps, own) {
  const half = 0.5 * dt;
  const turnLimit = LARGEST_TURN / dt * (LARGEST_TURN / dt);
  for (let n = 0; n < steps; n += 1) {
    const { rotation, velocity, momentum, wings, rates } = state;
    const first = load(rotation, velocity, momentum, wings, rates, own);
    const midway = extrapolate(velocity, first.acceleration, half);
    const second = load(
      rotateQuaternion(rotation, first.spin, half),
      midway,
      extrapolate(momentum, first.torque, half),
      extrapolate(wings, rates, half),
      rates,
      own,
    );
    const next = extrapolate(velocity, second.acceleration, dt);
    // Comparisons with NaN are false, so NaN counts as unstable.
    if (state.alive && squared(next) < FASTEST * FASTEST && squared(second.spin) < turnLimit) {
      state.position = extrapolate(state.position, midway, dt);
      state.rotation = rotateQuaternion(rotation, second.spin, dt);
      state.velocity = next;
      state.momentum = extrapolate(momentum, second.torque, dt);
    } else {
      state.alive = false;
    }
    state.wings = extrapolate(wings, rates, dt);
  }
}
