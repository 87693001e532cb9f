"""Inputs and commands of the network, and the flight that it controls; compiled code."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import LEAKY_RELU, RELU, SIGMOID, TANH, activation_with, compiled
from gaitsim_fly.course import CLIMB, COURSE, HALF_COS, HALF_SIN, SPEED, TURN, X, Y, Z, heading_of
from gaitsim_fly.flight import (
    ALIVE,
    BUFFER,
    LANES,
    POSITION_SCALE,
    RATES,
    SPIN_SCALE,
    STATE,
    VELOCITY,
    VELOCITY_SCALE,
    WING_SPEED,
    WINGS,
    Buffer,
    copy_lanes,
    rotation_matrix,
    spin_of,
    step,
)
from gaitsim_fly.options import BODY_INPUTS

_SATURATED = 20.0  # tanh differs from 1 by less than half a unit in the last place


@compiled.part
def tanh(x: Any) -> Any:
    """Return the hyperbolic tangent to 1e-13.

    Uses Lambert's continued fraction at x/16, then tanh 2y = 2 tanh y / (1 + tanh² y) four
    times. The system's tanh takes four times as long and differs between systems.
    """
    x = min(max(x, -_SATURATED), _SATURATED)
    y = 0.0625 * x
    z = y * y
    above = y * (2027025.0 + z * (270270.0 + z * (6930.0 + z * 36.0)))
    below = 2027025.0 + z * (945945.0 + z * (51975.0 + z * (630.0 + z)))
    t = above / below
    for _ in range(4):
        t = (t + t) / (1.0 + t * t)
    return t


_activated = njit(inline="always", error_model="numpy")(activation_with(tanh))


@njit(nogil=True, cache=True, error_model="numpy")
def activate(code: int, x: NDArray[np.float64]) -> None:
    """Apply an activation to every number of a vector, in place."""
    # Separate loops vectorise, unlike one loop that selects the activation.
    if code == TANH:
        for i in range(len(x)):
            x[i] = _activated(TANH, x[i])
    elif code == SIGMOID:
        for i in range(len(x)):
            x[i] = _activated(SIGMOID, x[i])
    elif code == RELU:
        for i in range(len(x)):
            x[i] = _activated(RELU, x[i])
    else:
        for i in range(len(x)):
            x[i] = _activated(LEAKY_RELU, x[i])


@compiled.part
def clip_to_unit(x: Any) -> Any:
    """Return x, clipped to ±1."""
    return min(max(x, -1.0), 1.0)


@njit(nogil=True, cache=True, error_model="numpy")
def fill_inputs(b: Buffer, g: Buffer, limits: Buffer, inputs: Buffer, c: Buffer) -> None:
    """Fill `inputs`, (inputs, LANES), with the inputs of the network, within ±1.

    Inputs are relative to the lane's course, (COURSE, LANES). Relative to a course that rests at
    the origin and heads along x, they are exactly those in the world frame.
    """
    for i in range(LANES):
        half_cos, half_sin = g[HALF_COS, i], g[HALF_SIN, i]
        cos, sin = heading_of(half_cos, half_sin)
        r = rotation_matrix(b[3, i], b[4, i], b[5, i], b[6, i])
        spin = spin_of(r, b[10, i], b[11, i], b[12, i], c)
        x, y, z = b[0, i] - g[X, i], b[1, i] - g[Y, i], b[2, i] - g[Z, i]
        inputs[0, i] = clip_to_unit((cos * x + sin * y) / c[POSITION_SCALE])
        inputs[1, i] = clip_to_unit((cos * y - sin * x) / c[POSITION_SCALE])
        inputs[2, i] = clip_to_unit(z / c[POSITION_SCALE])
        w = half_cos * b[3, i] + half_sin * b[6, i]
        sign = 1.0 if w >= 0.0 else -1.0  # q and −q are the same rotation
        inputs[3, i] = sign * (half_cos * b[4, i] + half_sin * b[5, i])
        inputs[4, i] = sign * (half_cos * b[5, i] - half_sin * b[4, i])
        inputs[5, i] = sign * (half_cos * b[6, i] - half_sin * b[3, i])
        ahead = cos * b[7, i] + sin * b[8, i] - g[SPEED, i]
        inputs[6, i] = clip_to_unit(ahead / c[VELOCITY_SCALE])
        inputs[7, i] = clip_to_unit((cos * b[8, i] - sin * b[7, i]) / c[VELOCITY_SCALE])
        inputs[8, i] = clip_to_unit((b[9, i] - g[CLIMB, i]) / c[VELOCITY_SCALE])
        inputs[9, i] = clip_to_unit((cos * spin[0] + sin * spin[1]) / c[SPIN_SCALE])
        inputs[10, i] = clip_to_unit((cos * spin[1] - sin * spin[0]) / c[SPIN_SCALE])
        inputs[11, i] = clip_to_unit((spin[2] - g[TURN, i]) / c[SPIN_SCALE])
        for angle in range(inputs.shape[0] - BODY_INPUTS):
            limit = limits[angle % 3]
            inputs[BODY_INPUTS + angle, i] = b[WINGS + angle, i] / limit if limit > 0.0 else 0.0


@njit(nogil=True, cache=True, error_model="numpy")
def _add_product(total: Buffer, weight: Buffer, value: Buffer) -> None:
    """Add weight · value in each lane; as a separate function, the loop vectorises."""
    for i in range(len(total)):
        total[i] += weight[i] * value[i]


@compiled.part
def _layer(genes: Buffer, first: int, inputs: Buffer, outputs: Buffer, code: int) -> Any:
    """Compute one layer of every lane's network; return the next layer's first gene."""
    fan_in = inputs.shape[0]
    bias = first + outputs.shape[0] * fan_in
    for unit in range(outputs.shape[0]):
        total = outputs[unit]
        for i in range(LANES):
            total[i] = genes[bias + unit, i]
        for source in range(fan_in):
            _add_product(total, genes[first + unit * fan_in + source], inputs[source])
        activate(code, total)
    return bias + outputs.shape[0]


@njit(nogil=True, cache=True, error_model="numpy")
def _compute_outputs(
    weights: Buffer, layers: Any, code: int, inputs: Buffer, values: Buffer, buffer: Buffer
) -> Any:
    """Return the outputs of every lane's network, (outputs, LANES), a view of a scratch buffer."""
    last = len(layers) - 1
    copy_lanes(inputs, values[: layers[0]])
    gene = 0
    for layer in range(1, last + 1):
        gene = _layer(
            weights,
            gene,
            values[: layers[layer - 1]],
            buffer[: layers[layer]],
            TANH if layer == last else code,
        )
        values, buffer = buffer, values
    return values[: layers[last]]


@njit(nogil=True, cache=True, error_model="numpy")
def _mirror(inputs: Buffer, mirrored: Buffer) -> None:
    """Fill `mirrored`, (18, LANES), with the inputs of the fly's mirror image, left for right."""
    for i in range(LANES):
        for axis in range(3):
            side = -1.0 if axis == 1 else 1.0  # rotation vectors change sign the other way
            mirrored[axis, i] = side * inputs[axis, i]
            mirrored[3 + axis, i] = -side * inputs[3 + axis, i]
            mirrored[6 + axis, i] = side * inputs[6 + axis, i]
            mirrored[9 + axis, i] = -side * inputs[9 + axis, i]
            mirrored[BODY_INPUTS + axis, i] = inputs[BODY_INPUTS + 3 + axis, i]
            mirrored[BODY_INPUTS + 3 + axis, i] = inputs[BODY_INPUTS + axis, i]


@compiled.part
def wing_commands(weights: Buffer, layers: Any, code: int, inputs: Buffer, outputs: Buffer) -> None:
    """Fill `outputs` with the wing commands of every lane's network, ±1 at the limits.

    Args:
        weights: weights and biases, (genes, LANES).
        layers: units of each layer, inputs first.
        code: activation of the hidden layers; the outputs always use tanh.
        inputs: inputs of the networks, (inputs, LANES).
        outputs: output, (3, LANES) for both wings or (6, LANES). If the network has only half of
            the outputs, a copy of it with mirrored inputs commands the right wing.
    """
    widest = layers.max()
    values, buffer = np.empty((widest, LANES)), np.empty((widest, LANES))
    each = layers[-1]
    copy_lanes(_compute_outputs(weights, layers, code, inputs, values, buffer), outputs[:each])
    if each < len(outputs):
        mirrored = np.empty((len(inputs), LANES))
        _mirror(inputs, mirrored)
        right = _compute_outputs(weights, layers, code, mirrored, values, buffer)
        copy_lanes(right, outputs[each:])


@njit(nogil=True, cache=True, error_model="numpy")
def command(
    b: Buffer, outputs: Buffer, limits: Buffer, offsets: Buffer, interval: float, speed: float
) -> None:
    """Set the rates that turn the wings to their commands within `interval`, up to `speed`."""
    for angle in range(6):
        limit = limits[angle % 3]
        for i in range(LANES):
            wanted = limit * outputs[angle % outputs.shape[0], i]  # three outputs command both
            wanted += offsets[angle]
            rate = (wanted - b[WINGS + angle, i]) / interval
            b[RATES + angle, i] = min(max(rate, -speed), speed)


@njit(nogil=True, cache=True, error_model="numpy")
def _follow(courses: Any, frame: int, first: int, count: int, g: Buffer) -> None:
    """Fill the courses of `count` lanes, (COURSE, LANES), starting with lane number `first`."""
    for i in range(LANES):
        trial = (first + min(i, count - 1)) % len(courses)
        for k in range(COURSE):
            g[k, i] = courses[trial, frame, k]


@njit(nogil=True, cache=True, error_model="numpy")
def _delay_outputs(sent: Any, frame: int, delay: float, outputs: Buffer) -> None:
    """Replace the network's outputs by those of `delay` commands ago.

    Args:
        sent: ring buffer of the latest outputs, (delay + 2 or more, outputs, LANES).
        frame: frame of the newest outputs.
        delay: delay in commands; a fractional delay interpolates between two commands.
        outputs: outputs to replace, (outputs, LANES).
    """
    size, whole = len(sent), int(delay)
    share = delay - whole
    copy_lanes(outputs, sent[frame % size])
    after, before = sent[(frame - whole) % size], sent[(frame - whole - 1) % size]
    for output in range(len(outputs)):
        for i in range(LANES):
            outputs[output, i] = after[output, i] + share * (before[output, i] - after[output, i])


@compiled.part
def _fill_lane(lane: int, numbers: Buffer, target: Buffer) -> None:
    """Fill a lane of `target`, (n or more, LANES); an assignment would take longer to compile."""
    for k in range(len(numbers)):
        target[k, lane] = numbers[k]


@njit(nogil=True, cache=True, error_model="numpy")
def fly(
    genes: NDArray[np.float64],
    start: NDArray[np.float64],
    courses: NDArray[np.float64],
    layers: NDArray[np.int64],
    code: int,
    limits: NDArray[np.float64],
    dt: float,
    steps: int,
    c: NDArray[np.float64],
    offsets: NDArray[np.float64],
    delay: float,
    push_frame: int,
    push: NDArray[np.float64],
    states: NDArray[np.float64],
    angles: NDArray[np.float64],
    lasted: NDArray[np.int64],
) -> None:
    """Simulate one lane for each trial of each individual, controlled by its network.

    Args:
        genes: weights of each individual, (individuals, genes).
        start: state of each trial at the start, (trials, STATE); see `flight`.
        courses: course of each trial, (trials, frames, COURSE); see `course`.
        layers: units of each layer, inputs first.
        code: activation of the hidden layers; the outputs always use tanh.
        limits: limits of flap, pitch and sweep, (3,) rad.
        dt: time step, s.
        steps: time steps between commands.
        c: constants; see `flight`.
        offsets: constant error of each wing angle, (6,) rad.
        delay: delay in commands; before the first command arrives, outputs are 0.
        push_frame: frame after which the velocity changes.
        push: change of the velocity, (3,) m/s.
        states: output, (individuals × trials, frames, STATE): states at every command and the end.
        angles: output, (individuals × trials, frames, 6): wing angles, rad.
        lasted: output, (individuals × trials,): number of stable frames.
    """
    lanes, frames, trials = states.shape[0], states.shape[1], start.shape[0]
    b = np.zeros((BUFFER, LANES))
    weights = np.empty((genes.shape[1], LANES))
    inputs = np.empty((layers[0], LANES))
    outputs = np.empty((layers[0] - BODY_INPUTS, LANES))
    sent = np.zeros((int(delay) + 2, len(outputs), LANES))
    g = np.empty((COURSE, LANES))
    for first in range(0, lanes, LANES):
        count = min(LANES, lanes - first)
        b[:] = 0.0
        sent[:] = 0.0
        for i in range(LANES):
            lane = first + min(i, count - 1)  # spare lanes repeat the last one
            _fill_lane(i, genes[lane // trials], weights)
            _fill_lane(i, start[lane % trials], b)
            _fill_lane(i, offsets, b[WINGS:])
            b[ALIVE, i] = 1.0
        lasted[first : first + count] = frames
        for frame in range(frames):
            for i in range(count):
                for k in range(STATE):
                    states[first + i, frame, k] = b[k, i]
                for k in range(6):
                    angles[first + i, frame, k] = b[WINGS + k, i]
                if b[ALIVE, i] == 0.0 and lasted[first + i] == frames:
                    lasted[first + i] = frame
            if frame == frames - 1:
                break
            _follow(courses, frame, first, count, g)
            if frame == push_frame:
                for axis in range(3):
                    for i in range(LANES):
                        b[VELOCITY + axis, i] += push[axis]
            fill_inputs(b, g, limits, inputs, c)
            wing_commands(weights, layers, code, inputs, outputs)
            if delay > 0.0:
                _delay_outputs(sent, frame, delay, outputs)
            command(b, outputs, limits, offsets, steps * dt, c[WING_SPEED])
            step(b, dt, steps, c)
