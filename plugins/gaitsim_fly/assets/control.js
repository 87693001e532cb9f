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
 * @property {number} positionScale - distance that becomes an input of 1, m
 * @property {number} velocityScale - speed that becomes an input of 1, m/s
 * @property {number} spinScale - angular speed that becomes an input of 1, rad/s
 */

const BODY_INPUTS = 12; // number of inputs before the wing angles
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

const clipToUnit = (x) => Math.min(Math.max(x, -1.0), 1.0);

/**
 * The course that a fly follows, see `course.py`: the reference of the network's inputs.
 * @typedef {Object} Course
 * @property {Vector} point - position of the course, m
 * @property {[number, number]} half - cosine and sine of half the heading
 * @property {Vector} speeds - forward and upwards, m/s, and turn to the left, rad/s
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
function networkInputs(state, course, control, own) {
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
  const angles = state.wings.slice(0, control.layers[0] - BODY_INPUTS);
  return [
    clipToUnit((cos * x + sin * y) / positionScale),
    clipToUnit((cos * y - sin * x) / positionScale),
    clipToUnit(z / positionScale),
    sign * (halfCos * q[1] + halfSin * q[2]),
    sign * (halfCos * q[2] - halfSin * q[1]),
    sign * (halfCos * q[3] - halfSin * q[0]),
    clipToUnit((cos * v[0] + sin * v[1] - ahead) / velocityScale),
    clipToUnit((cos * v[1] - sin * v[0]) / velocityScale),
    clipToUnit((v[2] - climb) / velocityScale),
    clipToUnit((cos * spin[0] + sin * spin[1]) / spinScale),
    clipToUnit((cos * spin[1] - sin * spin[0]) / spinScale),
    clipToUnit((spin[2] - turn) / spinScale),
    ...angles.map((angle, i) => (limits[i % 3] > 0.0 ? angle / limits[i % 3] : 0.0)),
  ];
}

/** Return the outputs of a network; genes are W1 row by row, b1, W2, b2 … */
function networkOutputs(genes, inputs, control) {
  let gene = 0;
  let values = inputs;
  const last = control.layers.length - 1;
  for (let layer = 1; layer <= last; layer += 1) {
    const activate = layer === last ? tanh : ACTIVATIONS[control.activation];
    const biases = gene + control.layers[layer] * values.length;
    const next = [];
    for (let unit = 0; unit < control.layers[layer]; unit += 1) {
      let total = genes[biases + unit];
      for (const value of values) {
        total += genes[gene] * value;
        gene += 1;
      }
      next.push(activate(total));
    }
    gene = biases + next.length;
    values = next;
  }
  return values;
}

/** Return the inputs of the fly's mirror image, left for right. */
function mirroredInputs(inputs) {
  const inMirror = (first, flipped) => [0, 1, 2].map((axis) =>
    ((axis === 1) === flipped ? -inputs[first + axis] : inputs[first + axis]));
  // Mirrored rotation vectors change the opposite signs.
  return [
    ...inMirror(0, true), ...inMirror(3, false), ...inMirror(6, true), ...inMirror(9, false),
    ...inputs.slice(BODY_INPUTS + 3), ...inputs.slice(BODY_INPUTS, BODY_INPUTS + 3),
  ];
}

/**
 * Return a network's wing commands, ±1 at the limits. If it has outputs for one wing only, a copy
 * with mirrored inputs commands the right wing.
 */
function wingCommands(genes, inputs, control) {
  const outputs = networkOutputs(genes, inputs, control);
  const missing = inputs.length - BODY_INPUTS > outputs.length;
  if (!missing) {
    return outputs;
  }
  return [...outputs, ...networkOutputs(genes, mirroredInputs(inputs), control)];
}

/** Set the rates that turn the wings to their commands in time, up to the largest speed. */
function command(state, outputs, control, own) {
  const interval = control.steps * control.dt;
  state.rates = state.wings.map((angle, i) => {
    // Three outputs command both wings.
    const wanted = control.limits[i % 3] * outputs[i % outputs.length];
    return Math.min(Math.max((wanted - angle) / interval, -own.wingSpeed), own.wingSpeed);
  });
}
