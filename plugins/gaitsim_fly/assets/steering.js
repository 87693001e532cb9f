"use strict";

// A steered fly: the operations of `steps.py`, `course.py` and `skeleton.py`.

/** Raise one share by `part`, at most to 1; scale the others so that the sum stays 1. */
function handOver(shares, to, part) {
  const before = shares[to];
  if (before < 1.0) {
    const after = Math.min(1.0, before + part);
    for (let k = 0; k < shares.length; k += 1) {
      shares[k] *= (1.0 - after) / (1.0 - before);
    }
    shares[to] = after;
  }
}

/** Return the mean of the controllers' values, weighted by their shares. */
function mean(shares, value) {
  let total = 0.0;
  for (let k = 0; k < shares.length; k += 1) {
    if (shares[k] > 0.0) {
      total += shares[k] * value(k);
    }
  }
  return total;
}

/** Advance a course: move it, then rotate it by less than half a turn. */
function advanceCourse(course, seconds) {
  const [cos, sin] = headingOf(course.half);
  const [speed, climb, turn] = course.speeds;
  const ahead = speed * seconds;
  course.point[0] += ahead * cos;
  course.point[1] += ahead * sin;
  course.point[2] += climb * seconds;
  const quarter = 0.5 * turn * seconds;
  const c = cosine(quarter), s = sine(quarter);
  const w = c * course.half[0] - s * course.half[1];
  const z = c * course.half[1] + s * course.half[0];
  const scale = 1.0 / Math.sqrt(w * w + z * z);
  course.half = [w * scale, z * scale];
}

/** Pull a course to within `leash` of the fly, horizontally and vertically. */
function hold(course, place, leash) {
  const x = course.point[0] - place[0], y = course.point[1] - place[1];
  const z = course.point[2] - place[2];
  const away = Math.sqrt(x * x + y * y);
  if (away > leash) {
    course.point[0] = place[0] + x * (leash / away);
    course.point[1] = place[1] + y * (leash / away);
  }
  course.point[2] = place[2] + Math.min(Math.max(z, -leash), leash);
}

/** Return the ends of a cuboid's edges, in the order of `body.cuboid`. */
function cuboid([length, width, height]) {
  const corners = [];
  for (const x of [1, -1]) {
    for (const y of [1, -1]) {
      for (const z of [1, -1]) {
        corners.push([x * length / 2, y * width / 2, z * height / 2]);
      }
    }
  }
  const ends = [];
  for (let a = 0; a < 8; a += 1) {
    for (let b = a + 1; b < 8; b += 1) {
      if (corners[a].filter((number, axis) => number !== corners[b][axis]).length === 1) {
        ends.push(corners[a], corners[b]);
      }
    }
  }
  return ends;
}

/** Return the ends of a wing's edges in the body's frame; the apex is at the hinge. */
function wingEnds(angles, side, { width, span, chord }) {
  const [flap, pitch, sweep] = angles;
  const sf = sine(flap), cf = cosine(flap), ss = sine(sweep), cs = cosine(sweep);
  const sp = sine(pitch), cp = cosine(pitch);
  // Rx(side flap) · Rz(−side sweep) · Ry(−pitch), for a point with z = 0 in the wing's frame
  const placed = (x, y) => {
    const alongX = cp * x, alongZ = sp * x;
    const turnedX = cs * alongX + side * ss * y, turnedY = cs * y - side * ss * alongX;
    return [
      turnedX,
      cf * turnedY - side * sf * alongZ + side * width / 2,
      side * sf * turnedY + cf * alongZ,
    ];
  };
  const apex = placed(0, 0), front = placed(chord / 2, side * span);
  const back = placed(-chord / 2, side * span);
  return [apex, front, front, back, back, apex];
}

/** Return the ends of all segments in the world frame, in the order of the fly's skeleton. */
function endsOf(state, shape, edges) {
  const r = rotationMatrix(state.rotation);
  const all = [
    ...edges,
    ...wingEnds(state.wings.slice(0, 3), 1, shape),
    ...wingEnds(state.wings.slice(3), -1, shape),
  ];
  const ends = new Float64Array(3 * all.length);
  all.forEach((point, index) => {
    toWorld(r, ...point).forEach((number, axis) => {
      ends[3 * index + axis] = number + state.position[axis];
    });
  });
  return ends;
}

/**
 * Create a steered fly with the interface that a steering page expects.
 * @param {Object} data - see `page.py`
 */
function steeredFly(data) {
  const { own, control, shape, speeds, controllers, names, leash } = data;
  const edges = cuboid([shape.length, shape.width, shape.height]);
  const interval = control.steps * control.dt;
  const part = data.interval / data.blend;
  const shares = names.map((_, k) => (k === 0 ? 1.0 : 0.0));
  const state = {
    position: [0.0, 0.0, data.altitude], rotation: [1.0, 0.0, 0.0, 0.0],
    velocity: [0.0, 0.0, 0.0], momentum: [0.0, 0.0, 0.0],
    wings: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0], rates: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0], alive: true,
  };
  const course = { point: [0.0, 0.0, data.altitude], half: [1.0, 0.0], speeds: [...speeds[0]] };

  function frame(commanded) {
    handOver(shares, commanded, part);
    course.speeds = course.speeds.map((_, axis) => mean(shares, (k) => speeds[k][axis]));
    const inputs = networkInputs(state, course, control, own);
    const outputsOf = names.map((_, k) =>
      (shares[k] > 0.0 ? wingCommands(controllers[k], inputs, control) : []));
    const outputs = outputsOf[commanded].map((_, i) => mean(shares, (k) => outputsOf[k][i]));
    command(state, outputs, control, own);
    step(state, control.dt, control.steps, own);
    advanceCourse(course, interval);
    hold(course, state.position, leash);
  }

  return {
    frameRate: 1 / data.interval,
    commands: data.commands,
    state,
    advance(name, frames) {
      for (let n = 0; n < frames; n += 1) {
        frame(names.indexOf(name));
      }
      const [w, x, y, z] = state.rotation;
      return {
        ends: endsOf(state, shape, edges),
        centre: [...state.position],
        shares: [...shares],
        failed: !state.alive,
        facts: {
          altitude: state.position[2],
          heading: Math.atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)),
        },
      };
    },
  };
}
