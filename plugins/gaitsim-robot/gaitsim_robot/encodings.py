"""Encodings of a robot, `steps`, `sine` and `cpg`: turn a genome into servo commands."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import SAMPLES, GaitsimError, Genomes, Legs, Rhythm
from gaitsim.plugin.toolkit import (
    GeneGroup,
    Oscillators,
    arctan2,
    cos,
    genome_space,
    limit_steps,
    norm,
    sin,
    split_genomes,
)
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.chain import Chain, pose_data, sliding, stacked
from gaitsim_robot.linkage import Linkage, standing_chains
from gaitsim_robot.simulation import FRAME_RATE

Symmetry = Literal["none", "alternating", "trot", "bound", "wave"]


def rows(anatomy: Anatomy) -> NDArray[np.intp]:
    """Return the row of each leg from front to back, 0 first, (legs,)."""
    return np.array([int(leg.name[1:]) - 1 for leg in anatomy.legs], np.intp)


def leaders(anatomy: Anatomy, symmetry: Symmetry) -> NDArray[np.intp]:
    """Return the index of the leg whose genes each leg uses, (legs,).

    With a symmetry, it is the left leg of the row, if both legs have equally many joints.
    """
    index = {leg.name: at for at, leg in enumerate(anatomy.legs)}
    found = []
    for at, leg in enumerate(anatomy.legs):
        left = index.get("L" + leg.name[1:], at) if leg.side == "right" else at
        alike = len(anatomy.legs[left].joints) == len(leg.joints)
        found.append(left if symmetry != "none" and alike else at)
    return np.array(found, np.intp)


def phases(anatomy: Anatomy, symmetry: Symmetry, lag: Floats) -> Floats:
    """Return the phase of each leg in its cycle, (population, legs) rad.

    - alternating: half a cycle between left and right, and between neighbours on a side: the walk
      of two legs, the trot of four, the tripods of six, the tetrapods of eight.
    - trot: the same as alternating, under its name for four legs.
    - bound: both legs of a row together, and half a cycle between neighbouring rows.
    - wave: half a cycle between left and right; each row starts `lag` after the row behind it.

    Args:
        anatomy: anatomy of the robot.
        symmetry: any symmetry except none.
        lag: delay between rows in a wave, (population,) rad; unused otherwise.
    """
    row = rows(anatomy)
    right = np.array([leg.side == "right" for leg in anatomy.legs], np.float64)
    if symmetry == "wave":
        return np.asarray(math.pi * right - lag[:, None] * (row.max() - row))
    halves = row if symmetry == "bound" else row + right
    return np.broadcast_to(math.pi * (halves % 2), (len(lag), len(row))).copy()


ITERATIONS = 12
SLOWEST_RETURN = -0.5  # stride lengths per swing, lower bound of the speed at the ends of a swing


def foot_path(phase: Floats, duty: Floats) -> tuple[Floats, Floats]:
    """Return the forward position of a foot, in strides, and its height, in lifts.

    In stance, the foot moves backward at constant speed. In swing, its position follows a cubic
    with almost that speed at both ends, so that the foot lands with little slip, and its height
    follows a squared sine.

    Args:
        phase: phase of the cycle from 0, the start of stance, to 1, (..., samples).
        duty: share of the cycle in stance, (..., 1).
    """
    swing = np.clip((phase - duty) / (1 - duty), 0.0, 1.0)
    slope = np.maximum(-(1 - duty) / duty, SLOWEST_RETURN)
    cubic = swing * swing * (3 - 2 * swing) - 0.5
    cubic = cubic + slope * swing * (1 - swing) * (1 - 2 * swing)
    ahead = np.where(phase < duty, 0.5 - phase / duty, cubic)
    return np.asarray(ahead), np.square(sin(math.pi * swing))


def cycle_angles(chain: Chain, targets: Floats, level: bool) -> Floats:
    """Return joint angles that move a leg's foot to the targets, or close to them.

    Args:
        chain: chain of the leg; its pose `zero` is the standing pose.
        targets: positions of the foot in the standing trunk's frame, (population, SAMPLES, 3) m.
        level: whether the foot keeps its orientation as far as its joints allow.

    Returns:
        The angles, (population, SAMPLES, joints) rad.
    """
    weights = chain.weights(level)
    return chain.solve(targets, chain.zero, chain.zero, weights, ITERATIONS)


def fastest_turn(angles: Floats) -> Floats:
    """Return the largest speed of each joint in cycles, (population, joints) rad per cycle."""
    fastest: Floats = np.abs(np.diff(angles, axis=1, append=angles[:, :1])).max(axis=1)
    return fastest * SAMPLES


def interpolate_cycle(angles: Floats, phase: Floats) -> Floats:
    """Return the angles of a cycle at any phase, interpolated with periodic cubics.

    Source: E. Catmull, R. Rom, A class of local interpolating splines (1974).

    Args:
        angles: angles of a cycle, (population, SAMPLES, joints) rad.
        phase: phase in cycles, (population, frames).

    Returns:
        The angles, (population, frames, joints) rad.
    """
    place = (phase - np.floor(phase)) * SAMPLES
    first = np.minimum(place.astype(np.intp), SAMPLES - 1)
    t = (place - first)[..., None]
    individuals = np.arange(len(angles))[:, None]
    a, b, c, d = (angles[individuals, (first + shift) % SAMPLES] for shift in (-1, 0, 1, 2))
    between: Floats = b + 0.5 * t * (
        c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a))
    )
    return between


def first_harmonic(angles: Floats) -> Floats:
    """Return the mean, amplitude and phase of A sin(2πt + φ) that fits a cycle of angles best.

    Args:
        angles: angles of a cycle, (SAMPLES, joints) rad.

    Returns:
        Mean, amplitude A and phase φ of each joint, (3, joints) rad.
    """
    cycle = 2 * math.pi * np.arange(SAMPLES) / SAMPLES
    sine = 2 * (sin(cycle)[:, None] * angles).mean(axis=0)
    cosine = 2 * (cos(cycle)[:, None] * angles).mean(axis=0)
    length = norm(np.stack([sine, cosine], axis=-1))
    return np.stack([angles.mean(axis=0), length, arctan2(cosine, sine)])


def _since_start(frames: int) -> Floats:
    """Return the time in each frame, (frames,) s, less what the start at low speed delays it."""
    time = np.arange(frames) / FRAME_RATE
    delayed: Floats = np.where(time < RAMP_TIME, time**2 / (2 * RAMP_TIME), time - RAMP_TIME / 2)
    return delayed


_ALTERNATING = {2: "walk", 4: "trot", 6: "tripod", 8: "tetrapod"}
"""Names of the gait with half a cycle between neighbouring legs, by number of legs."""

Kind = Literal["steps", "sine", "cpg"]

SLOWEST = 0.3  # Hz, lower bound of the frequency gene
# Bounds in the sine and cpg encodings, rad, or for slides × half their range.
SWING = 0.6  # largest amplitude of a joint
OFFSET = 0.3  # largest offset from the standing pose
RAMP_TIME = 0.5  # s, duration of the transition from standing to the full gait
COUPLING = 4.0  # 1/s, coupling to the leading oscillator
LENGTHS = frozenset({"stride", "lift", "height", "shift", "spread", "sway"})
"""Gene groups whose values are in lengths of the legs, so that a gait suits other dimensions."""

LONGER = 1.25  # × a gait's longest stroke, up to which commands may lengthen strokes
SHORTEST = 0.3  # × length of the legs, up to which commands may lengthen any strokes


@dataclass(frozen=True, eq=False)
class Encoding:
    """An encoding of the gaits of one robot.

    Attributes:
        model: `mujoco.MjModel` of the robot, with or without its ground.
        anatomy: anatomy of the robot.
        top_speed: speed limit of the commands for each joint of the anatomy, (joints,) rad/s.
        kind: `steps`: each foot follows a step cycle around its standing position, which inverse
            kinematics turns into joint angles. `sine`: each joint follows a sine. `cpg`: each
            joint follows the sine of a coupled oscillator.
        symmetry: symmetry of the legs; see `symmetry.phases`.
        fastest: upper bound of the frequency gene, Hz.
        heading: direction of the strides of `steps`, from forward to the left, rad.
        walks: whether the legs move; otherwise they hold the standing pose, and wheels roll.
        bodies: encodings of the individuals of a population with their own dimensions, which
            share everything but the legs' geometry; () for one body.
    """

    model: Any
    anatomy: Anatomy
    top_speed: Floats
    kind: Kind = "steps"
    symmetry: Symmetry = "none"
    fastest: float = 2.5
    heading: float = 0.0
    walks: bool = True
    bodies: tuple["Encoding", ...] = ()

    @cached_property
    def groups(self) -> tuple[GeneGroup, ...]:
        """The gene groups; their lengths are in lengths of the legs."""
        groups, swing = self._leg_groups(), self.anatomy.swing
        if not self.walks:
            groups = tuple(group for group in groups if group.name == "frequency")
        if swing:
            groups += (
                GeneGroup("swing", swing, 0.0, SWING * self._scale(swing)),
                GeneGroup("swing phase", swing, -math.pi, math.pi, periodic=True),
            )
        if rolling := self.anatomy.rolling:
            fastest = float(self.top_speed[-len(rolling) :].min())
            groups += (GeneGroup("roll", ("",), -fastest, fastest),)
        return groups

    def _leg_groups(self) -> tuple[GeneGroup, ...]:
        legs = self.anatomy.legs
        own = [leg.name for leg, at in zip(legs, self._leaders, strict=True) if leg is legs[at]]
        turn = math.pi
        frequency = GeneGroup("frequency", ("",), SLOWEST, self.fastest)
        free = self.symmetry == "none"
        timing = [GeneGroup("phase", tuple(own), -turn, turn, periodic=True)] if free else []
        if self.symmetry == "wave":
            timing = [GeneGroup("lag", ("",), 0.0, turn)]
        if self.kind == "steps":
            return (*self._step_groups(tuple(own) if free else ("",)), *timing, frequency)
        joints = tuple(joint for leg in legs if leg.name in own for joint in leg.joints)
        scale = self._scale(joints)
        return (
            GeneGroup("amplitude", joints, 0.0, SWING * scale),
            GeneGroup("offset", joints, -OFFSET * scale, OFFSET * scale),
            GeneGroup("delay", joints, -turn, turn, periodic=True),
            *timing,
            frequency,
        )

    def _scale(self, joints: Sequence[str]) -> Floats:
        """Return the unit of amplitudes: 1 rad for hinges, half the range for slides, m."""
        ids = [self.model.joint(name).id for name in joints]
        half = np.ptp(self.model.jnt_range[ids], axis=1) / 2
        return np.where(sliding(self.model)[ids], half, 1.0)

    @property
    def genes(self) -> int:
        """Number of genes of the encoding."""
        return sum(len(group.parts) for group in self.groups)

    @cached_property
    def legs(self) -> Legs:
        """The legs, for reflexes."""
        names = tuple(leg.name for leg in self.anatomy.legs)
        size = self._size[:, 0] if self.bodies else self._size
        return Legs.of(names, self._tips, size, self._joints)

    def commands(self, genomes: Genomes, frames: int) -> tuple[Floats, Floats]:
        """Return the commands to the servos, and the stride frequency.

        The commands start in the standing pose, and stay within the limits of the joints and
        `top_speed` for any genome. A step cycle that is too fast for the servos is slowed down.

        Returns:
            The commands, (population, frames, joints) rad, and the frequency, (population,) Hz.
        """
        values, phase = self._decoded(genomes)
        legs, swing, rolling = self._joints, self.anatomy.swing, self.anatomy.rolling
        if self.walks:
            play = self._play_steps if self.kind == "steps" else self._play_oscillators
            angles, frequency = play(values, phase, frames)
        else:
            angles, frequency = np.zeros((len(genomes), frames, legs)), values["frequency"][:, 0]
        if swing:
            cycles = frequency[:, None, None] * (np.arange(frames) / FRAME_RATE)[:, None]
            turn = 2 * math.pi * cycles + values["swing phase"][:, None]
            most = self.top_speed[legs : legs + len(swing)]
            swung = np.minimum(values["swing"], most / (2 * math.pi * frequency[:, None]))
            angles = np.concatenate([angles, swung[:, None] * sin(turn)], axis=2)
        angles *= np.clip(np.arange(frames) / (RAMP_TIME * FRAME_RATE), 0, 1)[:, None]
        if rolling:
            turned = values["roll"][:, None] * self._forward * _since_start(frames)[:, None]
            angles = np.concatenate([angles, turned], axis=2)
        standing, lower, upper = self._all_joints
        angles += standing
        np.clip(angles, lower, upper, out=angles)
        limited = limit_steps(angles.swapaxes(1, 2), self.top_speed / FRAME_RATE)
        return np.ascontiguousarray(limited.swapaxes(1, 2), np.float64), frequency

    @cached_property
    def _all_joints(self) -> Floats:
        """Standing, smallest and largest angles of the anatomy's joints, (3, …, joints) rad."""
        found = np.stack([self._standing, *self._limits])
        for name in (*self.anatomy.swing, *self.anatomy.rolling):
            joint = self.model.joint(name)
            ends = (-np.inf, np.inf) if name in self.anatomy.rolling else joint.range
            column = np.empty((*found.shape[:-1], 1))
            for row, value in enumerate((self.anatomy.stance[joint.qposadr[0]], *ends)):
                column[row] = value
            found = np.concatenate([found, column], axis=-1)
        return found

    @cached_property
    def _forward(self) -> Floats:
        """The direction of turning in which each wheel rolls forward, (wheels,), 1 or −1."""
        data = pose_data(self.model, self.anatomy.stance)
        axes = data.xaxis[[self.model.joint(name).id for name in self.anatomy.rolling]]
        return np.where(axes[:, 1] < 0, -1.0, 1.0)

    def rhythm(self, genomes: Genomes) -> Rhythm:
        """Return the gaits as rhythms, whose strokes commands and reflexes change.

        The feet of the encodings `sine` and `cpg` follow the paths of the full gait.

        Raises:
            GaitsimError: a leg is a closed linkage or slides, or joints outside the legs swing.
        """
        linked = any(isinstance(chain, Linkage) or chain.slides.any() for chain in self.chains)
        if linked or self.anatomy.swing or self.anatomy.rolling:
            parts = "closed linkages, couplings or slides" if linked else "a spine, tail or wheels"
            raise GaitsimError(
                f"commands, reflexes and controllers in C cannot move {parts}",
                remedy="leave out 'organism.reflexes' and 'organism.drive'"
                + ("" if linked else ", or 'organism.swing' and 'organism.wheels'")
                + "; formats such as csv export the gait as joint angles",
            )
        values, phase = self._decoded(genomes)
        walk = self._walk_steps if self.kind == "steps" else self._walk_oscillators
        duty, frequency, stroke, centre, path, offset = walk(values, phase)
        chains, legs = self.chains, self.anatomy.legs
        longest = norm(stroke).max(axis=1)

        def flat(values: Floats) -> Floats:
            return values[:, 0] if self.bodies else values  # without the axis of samples

        return Rhythm(
            names=self.legs.names,
            joint_names=self.anatomy.joints,
            first=np.cumsum([0, *(chain.zero.shape[-1] for chain in chains)]),
            anchors=flat(np.concatenate([chain.anchors for chain in chains], axis=-2)),
            axes=flat(np.concatenate([chain.axes for chain in chains], axis=-2)),
            tips=self._tips,
            standing=flat(self._standing),
            lower=flat(self._limits[0]),
            upper=flat(self._limits[1]),
            speed_limit=self.top_speed,
            weights=flat(
                np.stack(
                    [chain.weights(any(leg.sole)) for chain, leg in zip(chains, legs, strict=True)],
                    axis=-2,
                )
            ),
            length=self._size[:, 0] if self.bodies else self._size,
            frequency=frequency,
            duty=duty,
            offset=offset,
            centre=centre,
            stroke=stroke,
            path=path,
            longest=np.maximum(LONGER * longest, SHORTEST * np.ravel(self._size)),
            gains=np.ones((len(genomes), 3)),
        )

    def _decoded(self, genomes: Genomes) -> tuple[dict[str, Floats], Floats]:
        """Return the values of each gene group, and the phase of each leg, (population, legs).

        Lengths are in metres.
        """
        names = [group.name for group in self.groups]
        values = dict(zip(names, split_genomes(genomes, self.groups), strict=True))
        for name in LENGTHS.intersection(values):
            values[name] = values[name] * self._size
        lag = values["lag"][:, 0] if "lag" in values else np.zeros(len(genomes))
        phase = values["phase"] if "phase" in values else phases(self.anatomy, self.symmetry, lag)
        return values, phase

    def fit(
        self, joint_angles: Floats, frequency: float, frame_rate: float
    ) -> tuple[Floats, Floats]:
        """Return the gait of sines that is closest to periodic joint angles, by least squares.

        The encoding must be `sine`, without symmetry, and no joint outside the legs may swing.

        Args:
            joint_angles: angles over whole cycles, (frames, joints) rad.
            frequency: cycles per second, Hz.
            frame_rate: frames per second, Hz.

        Returns:
            The genome, (genes,), within its bounds, and its angles, (frames, joints) rad.
        """
        if self.anatomy.swing or self.anatomy.rolling:
            raise GaitsimError("a gait of given joint angles cannot move a spine, tail or wheels")
        time = np.arange(len(joint_angles))[:, None] / frame_rate
        turn = 2 * math.pi * frequency * time
        waves = np.concatenate([np.ones_like(turn), sin(turn), cos(turn)], axis=1)
        mean, sine, cosine = np.linalg.lstsq(waves, joint_angles - self._standing, rcond=None)[0]
        genome = self._genome(
            {
                "offset": mean,
                "amplitude": norm(np.stack([sine, cosine], axis=-1)),
                "delay": arctan2(cosine, sine),
                "phase": np.zeros(len(self.chains)),
                "frequency": np.array([frequency]),
            }
        )
        amplitude, offset, delay, played = self._oscillation(self._decoded(genome[None])[0])
        angles = self._standing + offset + amplitude * sin(2 * math.pi * played * time + delay)
        return genome, np.clip(angles, *self._limits)

    def starts(self) -> dict[str, Floats]:
        """Return gaits made by hand, by name, as genomes (genes,).

        The symmetry chooses the gait; with the symmetry 'none', there are two, an alternating one
        and a wave. The step cycles are long and low. In the encodings `sine` and `cpg`, each
        joint follows the first harmonic of its angle in such a cycle.
        """
        alternating = _ALTERNATING.get(len(self.anatomy.legs), "alternating")
        if self.symmetry in ("bound", "wave"):
            return {self.symmetry: self._gait(self.symmetry)}
        found = {alternating: self._gait("alternating")}
        if self.symmetry == "none" and len(self.anatomy.legs) > 2:
            found["wave"] = self._gait("wave")
        return found

    def _gait(self, gait: Symmetry) -> Floats:
        """Return the genome of a gait of long, low step cycles."""
        steps = replace(self, kind="steps")
        genome = steps._genome(steps._values(gait))
        if self.kind == "steps":
            return genome
        whole = steps._decoded(genome[None])[0]
        harmonic = []
        for leg, at in enumerate(self._leaders.tolist()):
            if leg == at:
                angles = steps._cycle(whole, np.zeros((1, len(self.chains))), leg)[0]
                harmonic.append(first_harmonic(angles - self.chains[leg].zero))
        offset, amplitude, delay = np.concatenate(harmonic, axis=1)
        return self._genome(
            self._values(gait) | {"offset": offset, "amplitude": amplitude, "delay": delay}
        )

    def _values(self, gait: Symmetry) -> dict[str, Floats]:
        """Return the values of a gait of long, low step cycles by gene group, (parts,) each."""
        # A wave of two rows is the walk of a quadruped, with a quarter of a cycle between its legs.
        lag = np.array([2 * math.pi / max(4, 1 + int(rows(self.anatomy).max()))])
        values = {
            "stride": 0.6,
            "lift": 0.08,
            "duty": 0.5,
            "sway": 0.08,
            "frequency": 1.8,
            "phase": phases(self.anatomy, gait, lag)[0],
            "lag": lag,
        }
        return {
            group.name: np.resize(values.get(group.name, 0.0), len(group.parts))
            for group in self.groups
        }

    def _genome(self, values: dict[str, Floats]) -> Floats:
        joined = np.concatenate([values[group.name] for group in self.groups])
        genome: Floats = genome_space(self.groups).repair(joined[None])[0]
        return genome

    @cached_property
    def chains(self) -> tuple[Chain, ...]:
        """The chains of the legs in the standing pose, of all bodies with an axis for samples."""
        if self.bodies:
            of_legs = zip(*(body.chains for body in self.bodies), strict=True)
            return tuple(stacked(chains, axes=1) for chains in of_legs)
        return standing_chains(self.model, self.anatomy)

    def _step_groups(self, own: tuple[str, ...]) -> tuple[GeneGroup, ...]:
        shared: tuple[GeneGroup, ...] = (
            GeneGroup("duty", ("",), 0.35, 0.85),
            GeneGroup("height", ("",), -0.2, 0.1),
            GeneGroup("shift", ("",), -0.2, 0.2),
            GeneGroup("spread", ("",), -0.15, 0.2),
        )
        if len(self.anatomy.legs) == 2:
            shared += (
                GeneGroup("sway", ("",), 0.0, 0.25),
                GeneGroup("sway lag", ("",), -math.pi / 2, math.pi / 2),
            )
        return (
            GeneGroup("stride", own, 0.0, 0.8),
            GeneGroup("lift", own, 0.03, 0.3),
            *shared,
        )

    def _play_steps(
        self, values: dict[str, Floats], phase: Floats, frames: int
    ) -> tuple[Floats, Floats]:
        """Return step cycles relative to the standing pose, and their frequency, as `commands`."""
        cycles = [self._cycle(values, phase, leg) for leg in range(len(self.chains))]
        frequency = self._slowed(values["frequency"], cycles)
        course = frequency * (np.arange(frames) / FRAME_RATE)
        played = [
            interpolate_cycle(angles, course + phase[:, [leg]] / (2 * math.pi))
            for leg, angles in enumerate(cycles)
        ]
        return np.concatenate(played, axis=2) - self._standing, frequency[:, 0]

    def _slowed(self, frequency: Floats, cycles: list[Floats]) -> Floats:
        """Return the frequency, (population, 1) Hz, reduced to what the servos can follow."""
        speed = [fastest_turn(angles) for angles in cycles]
        allowed = self.top_speed[: self._joints] / np.maximum(np.concatenate(speed, axis=1), 1e-9)
        slowed: Floats = np.minimum(frequency, allowed.min(axis=1, keepdims=True))
        return slowed

    def _cycle(self, values: dict[str, Floats], phase: Floats, leg: int) -> Floats:
        """Return one leg's joint angles over its cycle, (population, SAMPLES, its joints) rad."""
        stroke, centre, path = self._foot(values, phase, leg)
        place = centre[:, None] + path
        place[..., :2] = centre[:, None, :2] + path[..., :1] * stroke[:, None]
        place[..., 1] += path[..., 1]
        chain = self.chains[leg]
        return cycle_angles(chain, chain.tip + place, any(self.anatomy.legs[leg].sole))

    def _foot(
        self, values: dict[str, Floats], phase: Floats, leg: int
    ) -> tuple[Floats, Floats, Floats]:
        """Return one leg's stroke (population, 2), centre (…, 3) and path, as in `Rhythm`."""
        own = leg if values["stride"].shape[1] > 1 else 0
        duty = values["duty"]
        time = np.broadcast_to(np.arange(SAMPLES) / SAMPLES, (len(phase), SAMPLES))
        ahead, high = foot_path(time, duty)
        side = {"left": 1.0, "right": -1.0, "middle": 0.0}[self.anatomy.legs[leg].side]
        stride = values["stride"][:, own]
        stroke = np.stack([cos(self.heading) * stride, sin(self.heading) * stride], axis=-1)
        centre = np.stack(
            [values["shift"][:, 0], side * values["spread"][:, 0], -values["height"][:, 0]], axis=-1
        )
        path = np.stack([ahead, np.zeros_like(ahead), values["lift"][:, [own]] * high], axis=-1)
        if "sway" in values:
            # The trunk is farthest to the left in the middle of the left foot's stance.
            turn = 2 * math.pi * (time - duty / 2) - phase[:, [leg]] + phase[:, :1]
            path[..., 1] = -values["sway"] * cos(turn + values["sway lag"])
        return stroke, centre, path

    def _walk_steps(self, values: dict[str, Floats], phase: Floats) -> tuple[Floats, ...]:
        """Return duty, frequency, strokes, centres, paths and offsets of step cycles."""
        legs = range(len(self.chains))
        feet = [self._foot(values, phase, leg) for leg in legs]
        stroke, centre, path = (np.stack(part, axis=1) for part in zip(*feet, strict=True))
        cycles = [self._cycle(values, phase, leg) for leg in legs]
        frequency = self._slowed(values["frequency"], cycles)[:, 0]
        return values["duty"][:, 0].copy(), frequency, stroke, centre, path, phase / (2 * math.pi)

    def _walk_oscillators(self, values: dict[str, Floats], phase: Floats) -> tuple[Floats, ...]:
        """Return duty, frequency, strokes, centres, paths and offsets of oscillations.

        Touch-down is where a foot is farthest forward, and lift-off where it is farthest back.
        """
        amplitude, offset, delay, frequency = self._oscillation(values)
        time = np.arange(SAMPLES) / SAMPLES
        population, legs, first = len(phase), len(self.chains), 0
        share, begin = np.empty((2, population, legs))
        stroke, centre = np.zeros((population, legs, 2)), np.zeros((population, legs, 3))
        path = np.zeros((population, legs, SAMPLES, 3))
        rows = np.arange(population)[:, None]
        for leg, chain in enumerate(self.chains):
            joints = slice(first, first := first + chain.zero.shape[-1])
            turn = 2 * math.pi * time[None, :, None] + delay[:, None, joints]
            swing = amplitude[:, None, joints] * sin(turn) + offset[:, None, joints]
            angles = np.clip(chain.zero + swing, chain.lower, chain.upper)
            foot = chain.place(angles) - chain.tip
            down, up = foot[..., 0].argmax(axis=1), foot[..., 0].argmin(axis=1)
            begin[:, leg] = down / SAMPLES
            share[:, leg] = np.clip((up - down) % SAMPLES / SAMPLES, 0.2, 0.8)
            foot = foot[rows, (down[:, None] + np.arange(SAMPLES)) % SAMPLES]
            span = np.ptp(foot[..., 0], axis=1)
            middle = foot.mean(axis=1)
            middle[:, 0] = foot[..., 0].min(axis=1) + span / 2
            path[:, leg] = foot - middle[:, None]
            path[:, leg, :, 0] /= np.maximum(span, 1e-9)[:, None]
            stroke[:, leg, 0], centre[:, leg] = span, middle
        return share.mean(axis=1), frequency, stroke, centre, path, phase / (2 * math.pi) - begin

    def _oscillation(self, values: dict[str, Floats]) -> tuple[Floats, Floats, Floats, Floats]:
        """Return amplitude, offset and delay of each joint, (population, joints) rad, and Hz."""
        source, sign = self._mirrors
        frequency = values["frequency"][:, 0].copy()  # contiguous, as that of steps
        amplitude = values["amplitude"][:, source]
        most = self.top_speed[: self._joints]
        amplitude = np.minimum(amplitude, most / (2 * math.pi * frequency[:, None]))
        offset = values["offset"][:, source] * sign
        return amplitude * sign, offset, values["delay"][:, source], frequency

    def _play_oscillators(
        self, values: dict[str, Floats], phase: Floats, frames: int
    ) -> tuple[Floats, Floats]:
        """Return oscillations relative to the standing pose, and their frequency, as `commands`."""
        of_joints = np.repeat(
            np.arange(len(self.chains)), [chain.zero.shape[-1] for chain in self.chains]
        )
        amplitude, offset, delay, frequency = self._oscillation(values)
        oscillators = Oscillators(of_joints, frames, FRAME_RATE)
        if self.kind == "cpg":
            alternating = phases(self.anatomy, "alternating", np.zeros(len(phase)))
            start = alternating if self.symmetry == "none" else phase
            angles = oscillators.cpg(
                amplitude,
                phase,
                delay,
                frequency,
                start=start,
                coupling="leader",
                strength=COUPLING,
            )
        else:
            angles = oscillators.sine(amplitude, phase, delay, frequency)
        angles += offset[:, :, None]
        return np.ascontiguousarray(angles.swapaxes(1, 2), np.float64), frequency

    @cached_property
    def _tips(self) -> Floats:
        """The feet in the standing pose, (legs, 3) m, or (bodies, legs, 3) m."""
        if self.bodies:
            return np.stack([body._tips for body in self.bodies])
        return np.array([chain.tip for chain in self.chains])

    @cached_property
    def _size(self) -> Any:
        """Mean length of the legs, m, or (bodies, 1) m."""
        if self.bodies:
            return np.array([[body._size] for body in self.bodies])
        return float(np.mean([leg.length for leg in self.anatomy.legs]))

    @property
    def _joints(self) -> int:
        """Number of joints of the legs."""
        return sum(chain.zero.shape[-1] for chain in self.chains)

    @cached_property
    def _leaders(self) -> NDArray[np.intp]:
        return leaders(self.anatomy, self.symmetry)

    @cached_property
    def _mirrors(self) -> tuple[NDArray[np.intp], Floats]:
        """Gene and sign of each joint; mirrored joints turn the other way about x and z."""
        first = dict.fromkeys(self._leaders.tolist(), 0)
        count = 0
        for leg in first:
            first[leg], count = count, count + self.chains[leg].zero.shape[-1]
        source, sign = [], []
        for leg, leader in enumerate(self._leaders.tolist()):
            mirrored = _of_first(self.chains[leader].mirrored_axes)
            own = _of_first(self.chains[leg].axes)
            for joint in range(len(own)):
                source.append(first[leader] + joint)
                opposed = leader != leg and mirrored[joint] @ own[joint] < 0
                sign.append(-1.0 if opposed else 1.0)
        return np.array(source, np.intp), np.array(sign)

    @cached_property
    def _standing(self) -> Floats:
        return np.concatenate([chain.zero for chain in self.chains], axis=-1)

    @cached_property
    def _limits(self) -> tuple[Floats, Floats]:
        lower = np.concatenate([chain.lower for chain in self.chains], axis=-1)
        return lower, np.concatenate([chain.upper for chain in self.chains], axis=-1)


def _of_first(axes: Floats) -> Floats:
    """Return the axes of the first of several bodies, (joints, 3)."""
    first: Floats = axes.reshape(-1, *axes.shape[-2:])[0]
    return first
