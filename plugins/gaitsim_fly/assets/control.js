"use strict";

// Inputs and commands of the network: the operations of `control.py` and `activations.py`.

/**
 * A network with the limits of its commands and the scales of its inputs.
 * @typedef {Object} Control
 * @property {number[]} layers - units of each layer, inputs first
 * @property {string} activation - activation of the hidden layers; the outputs always use tanh
 * @property {Vector} limits - limits of flap, pitch and sweep, rad
 * @property {number} dt - time step of the simulation, s
 * @property {number} steps - time steps between commands
 * @property {number} positionScale - distance at which an input reaches 1, m
 * @property {number} velocityScale - speed at which an input reaches 1, m/s
 * @property {number} spinScale - angular speed at which an input reaches 1, rad/s
 */

const SEEN = 12; // inputs of a network before the wing angles
const LEAK = 0.01; // slope of the leaky ReLU below zero

/** Return tanh to 1e-13 as in `activations.py`, because Math.tanh differs between browsers. */
function tanh(x) {
  const y = 0.0625 * Math.min(Math.max(x, -20.0), 20.0);
  const z = y * y;
  const above = y * (2027025.0 + z * (270270.0 + z * (6930.0 + z * 36.0)));
  const below = 2027025.0 + z * (945945.0 + z * (51975.0 + z * (630.0 + z)));
  let t = above / below;
  for (let n = 0; n < 4; n += 1) {
    t = (t + t) / (1.0 + t * t);
  }
  return t;
}

/** @type {Object<string, function(number): number>} */
const ACTIVATIONS = {
  tanh,
  sigmoid: (z) => (1 + tanh(z / 2)) / 2,
  relu: (z) => Math.max(z, 0),
  "leaky-relu": (z) => Math.max(z, LEAK * z),
};

const within = (x) => Math.min(Math.max(x, -1.0), 1.0);

/**
 * The course that a fly follows, see `course.py`: the reference of the network's inputs.
 * @typedef {Object} Course
 * @property {Vector} point
 * @property {[number, number]} half - cosine and sine of half the heading
 * @property {Vector} speeds - forward, m/s, upwards, m/s, and turn to the left, rad/s
 */

/** A course that rests at the origin and heads along x: inputs are in the world frame. */
const WORLD = { point: [0, 0, 0], half: [1, 0], speeds: [0, 0, 0] };

/** Return the cosine and sine of a heading, given those of half the heading. */
function headingOf([cos, sin]) {
  return [cos * cos - sin * sin, 2.0 * cos * sin];
}

/**
 * Return the inputs of the network, relative to a course, within ±1.
 * @param {State} state
 * @param {Course} course
 * @param {Control} control
 * @param {Mechanics} own
 */
function see(state, course, control, own) {
  const { positionScale, velocityScale, spinScale, limits } = control;
  const [halfCos, halfSin] = course.half;
  const [cos, sin] = headingOf(course.half);
  const [ahead, climb, turn] = course.speeds;
  const q = state.rotation, v = state.velocity;
  const spin = spinOf(rotationMatrix(q), state.momentum, own.inverseInertia);
  const x = state.position[0] - course.point[0];
  const y = state.position[1] - course.point[1];
  const z = state.position[2] - course.point[2];
  const w = halfCos * q[0] + halfSin * q[3];
  const sign = w >= 0.0 ? 1.0 : -1.0; // q and −q are the same rotation
  const angles = state.wings.slice(0, control.layers[0] - SEEN);
  return [
    within((cos * x + sin * y) / positionScale),
    within((cos * y - sin * x) / positionScale),
    within(z / positionScale),
    sign * (halfCos * q[1] + halfSin * q[2]),
    sign * (halfCos * q[2] - halfSin * q[1]),
    sign * (halfCos * q[3] - halfSin * q[0]),
    within((cos * v[0] + sin * v[1] - ahead) / velocityScale),
    within((cos * v[1] - sin * v[0]) / velocityScale),
    within((v[2] - climb) / velocityScale),
    within((cos * spin[0] + sin * spin[1]) / spinScale),
    within((cos * spin[1] - sin * spin[0]) / spinScale),
    within((spin[2] - turn) / spinScale),
    ...angles.map((angle, i) => (limits[i % 3] > 0.0 ? angle / limits[i % 3] : 0.0)),
  ];
}

/** Return the outputs of a network; genes are W1 row by row, b1, W2, b2 … */
function outputsOf(genes, seen, control) {
  let gene = 0;
  let here = seen;
  const last = control.layers.length - 1;
  for (let layer = 1; layer <= last; layer += 1) {
    const activate = layer === last ? tanh : ACTIVATIONS[control.activation];
    const biases = gene + control.layers[layer] * here.length;
    const there = [];
    for (let to = 0; to < control.layers[layer]; to += 1) {
      let total = genes[biases + to];
      for (const value of here) {
        total += genes[gene] * value;
        gene += 1;
      }
      there.push(activate(total));
    }
    gene = biases + there.length;
    here = there;
  }
  return here;
}

/** Return the inputs of the fly's mirror image, left for right. */
function mirrored(seen) {
  const inMirror = (first, flipped) => [0, 1, 2].map((axis) =>
    ((axis === 1) === flipped ? -seen[first + axis] : seen[first + axis]));
  // Rotation vectors change sign the other way.
  return [
    ...inMirror(0, true), ...inMirror(3, false), ...inMirror(6, true), ...inMirror(9, false),
    ...seen.slice(SEEN + 3), ...seen.slice(SEEN, SEEN + 3),
  ];
}

/**
 * Return a network's wing commands, ±1 at the limits. If it has outputs for one wing only, a copy
 * with mirrored inputs commands the right wing.
 */
function answer(genes, seen, control) {
  const outputs = outputsOf(genes, seen, control);
  const missing = seen.length - SEEN > outputs.length;
  return missing ? [...outputs, ...outputsOf(genes, mirrored(seen), control)] : outputs;
}

/** Set the rates that turn the wings to their commands in time, up to the largest speed. */
function command(state, outputs, control, own) {
  const interval = control.steps * control.dt;
  state.rates = state.wings.map((angle, i) => {
    const wanted = control.limits[i % 3] * outputs[i % outputs.length]; // three command both
    return Math.min(Math.max((wanted - angle) / interval, -own.wingSpeed), own.wingSpeed);
  });
}
