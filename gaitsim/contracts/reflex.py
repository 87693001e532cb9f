"""The contract of a reflex, and the rhythm of a gait that reflexes and commands change.

A gait with reflexes is a rhythm with inputs. At the control rate, the body reads its sensors, each
reflex adds its changes to the inputs, and the rhythm advances to the next joint angles.
"""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.plugin import Plugin
from gaitsim.portable import norm

Floats = NDArray[np.float64]

COMMAND = ("speed", "turn", "sideways", "height")
"""The parts of a command: m/s forward, rad/s to the left, m/s to the left, and m upward."""
OBSERVATIONS = ("orientation", "rates", "contacts", "load", "joints")
"""Fields of `Observation` that depend on the robot's sensors, and that a reflex may need."""


@dataclass(frozen=True, eq=False)
class Legs:
    """The legs of a body, for reflexes.

    In a population whose individuals have their own dimensions, feet and length have a leading
    axis, (population, …).

    Attributes:
        names: names of the legs, such as L1.
        feet: standing feet relative to their mean, (…, legs, 2) m: x forward, y to the left.
        length: mean length of the legs, (…) m.
        joints: number of joints of all legs.
    """

    names: tuple[str, ...]
    feet: Floats
    length: float | Floats
    joints: int

    @classmethod
    def of(
        cls, names: tuple[str, ...], tips: Floats, length: float | Floats, joints: int
    ) -> "Legs":
        """Return legs with their feet at `tips` in the standing pose, (…, legs, 3) m."""
        feet = tips[..., :2] - tips[..., :2].mean(axis=-2, keepdims=True)
        return cls(names, feet, length, joints)


@dataclass(eq=False)
class Observation:
    """The measurements and the command of a body in one control step.

    Attributes:
        orientation: measured roll to the right, pitch nose down and yaw to the left since the
            start, (population, 3) rad.
        rates: measured angular velocity about the trunk's axes, (population, 3) rad/s.
        contacts: whether each foot touches the ground, (population, legs), 0 or 1.
        load: vertical force on each foot as a share of the weight, (population, legs).
        joints: measured joint angles, (population, joints) rad.
        command: the command, (population, 4), in the order of `COMMAND`.
        heading: direction that the commands ask for, the integral of the commanded turns, less
            what the gait cannot do, (population,) rad.
        phase: phase of each leg, (population, legs) cycles: 0 is touch-down, and stance lasts until
            `duty`.
        duty: share of the cycle in stance, (population, 1).
    """

    orientation: Floats
    rates: Floats
    contacts: Floats
    load: Floats
    joints: Floats
    command: Floats
    heading: Floats
    phase: Floats
    duty: Floats


@dataclass(eq=False)
class Inputs:
    """The inputs of a rhythm, which reflexes change in place.

    Attributes:
        command: the command with the changes of reflexes, (population, 4), as `COMMAND`.
        stride: factor of the stroke of each leg, (population, legs); 1 by default.
        reach: additional length of each leg, (population, legs) m; 0 by default.
        rate: factor of the speed of each leg's phase, (population, legs); 1 by default.
    """

    command: Floats
    stride: Floats
    reach: Floats
    rate: Floats

    @classmethod
    def unchanged(cls, command: Floats, legs: int) -> "Inputs":
        """Return the inputs before any reflex, with a copy of the command, (population, 4)."""
        shape = len(command), legs
        return cls(command.copy(), np.ones(shape), np.zeros(shape), np.ones(shape))


class Reflex(Plugin):
    """A rule that changes a gait by the measurements of sensors.

    Its options may be genes of the body: then a field holds one value for each individual,
    (population,), instead of a number. Code with NumPy's broadcasting works for both.

    Attributes:
        needs: names of the observations that it reads, of `OBSERVATIONS`.
    """

    needs: ClassVar[tuple[str, ...]] = ()

    def weights(self, legs: Legs) -> int:
        """Return the number of genes, from −1 to 1, of the reflex; 0 by default."""
        return 0

    def start(self, legs: Legs, weights: Floats) -> dict[str, Floats]:
        """Return the state at the start: named arrays, each (population, …); {} by default.

        Args:
            legs: legs of the body.
            weights: genes of the reflex, (population, weights).
        """
        return {}

    @abstractmethod
    def step(
        self, state: dict[str, Floats], seen: Observation, inputs: Inputs, interval: float
    ) -> None:
        """Add the changes to the inputs in place, and advance the state in place.

        The result for an individual must not depend on the rest of the population.

        Args:
            state: state from `start`; its arrays are changed in place.
            seen: observations and command of this control step.
            inputs: inputs of the rhythm, with the changes of the reflexes before this one.
            interval: duration of a control step, s.
        """

    def c99(self) -> str:
        """Return the body of `step` as C99 for one individual; '' if it cannot be exported.

        It may use `seen`, `inputs` and `interval` as above, `o->NAME` for options, `s->NAME` for
        the state, `GAIT_LEGS`, and the function `gait_clip(value, low, high)`. Arrays are indexed
        from 0 without the population axis: `seen->orientation[2]` is the yaw.
        """
        return ""


FASTEST_TURN = math.pi / 2  # rad/s, limit of the turn on six legs or more
TROT_TURN = math.pi / 4  # rad/s, limit on fewer legs, which tip over in faster turns
HEIGHT = 0.15  # × length of the legs, the largest commanded change of height
SAMPLES = 32
"""Number of samples of a foot's path in a cycle; between them, paths are interpolated."""


@dataclass(frozen=True, eq=False)
class Rhythm:
    """The gaits of a population as rhythms with inputs, in the frame of the standing trunk.

    The foot of a leg is at tip + centre + ahead · stroke + (0, side, up), where stroke is the part
    of its own stroke that the command asks for, and what turning and walking sideways add. Inverse
    kinematics turns it into joint angles.

    Joints are numbered leg by leg, from the hip to the foot; the legs' joints are hinges in series.
    If the individuals have their own dimensions, the geometry, from `anchors` to `length`, has a
    leading axis, (population, …), except for `speed_limit`.

    Attributes:
        names: names of the legs.
        joint_names: names of all joints.
        first: index of the first joint of each leg, and the number of all joints, (legs + 1,).
        anchors: a point on each axis in the standing pose, (joints, 3) m.
        axes: direction of each axis in the standing pose, (joints, 3).
        tips: position of each foot in the standing pose, (legs, 3) m.
        standing: standing pose, (joints,) rad.
        lower: smallest angles, (joints,) rad.
        upper: largest angles, (joints,) rad.
        speed_limit: fastest commands, (joints,) rad/s.
        weights: weights of each foot's errors in x, y, z, and of its rotations in metres per
            radian, (legs, 6).
        length: mean length of the legs, m.
        frequency: strides per second, (population,) Hz.
        duty: share of a cycle in stance, (population,).
        offset: phase of each leg at the start of the cycle, (population, legs) cycles.
        centre: mean foot position relative to the tip, (population, legs, 3) m.
        stroke: own stroke of each leg, forward and to the left, (population, legs, 2) m.
        path: foot paths: ahead, in strokes, side and up, m, (population, legs, SAMPLES, 3).
        longest: largest stroke of a leg, (population,) m; longer ones are shortened for all legs.
        gains: true speed, turn and sideways speed as shares of what strokes without slip would
            give, (population, 3).
    """

    names: tuple[str, ...]
    joint_names: tuple[str, ...]
    first: NDArray[np.int64]
    anchors: Floats
    axes: Floats
    tips: Floats
    standing: Floats
    lower: Floats
    upper: Floats
    speed_limit: Floats
    weights: Floats
    length: float | Floats
    frequency: Floats
    duty: Floats
    offset: Floats
    centre: Floats
    stroke: Floats
    path: Floats
    longest: Floats
    gains: Floats

    def __len__(self) -> int:
        return len(self.frequency)

    @property
    def legs(self) -> Legs:
        """The legs, for reflexes."""
        return Legs.of(self.names, self.tips, self.length, self.standing.shape[-1])

    @property
    def own_speed(self) -> Floats:
        """Speed of the gait as it evolved, in its own direction, (population,) m/s."""
        mean: Floats = norm(self.stroke).mean(axis=1) * self.frequency / self.duty
        return mean * self.gains[:, 0]

    @property
    def limits(self) -> Floats:
        """Largest commands without shortened strokes, one at a time, (population, 4)."""
        feet = self.legs.feet
        radius = np.maximum(norm(feet).max(axis=-1), 1e-9)
        fastest = FASTEST_TURN if feet.shape[-2] >= 6 else TROT_TURN
        straight = self.longest * self.frequency / self.duty  # m/s, of the foot that moves most
        share = self.longest / np.maximum(norm(self.stroke).max(axis=1), 1e-9)
        return np.stack(
            [
                self.own_speed * share,
                np.minimum(self.gains[:, 1] * straight / radius, fastest),
                self.gains[:, 2] * straight,
                np.broadcast_to(HEIGHT * self.length, len(self)),
            ],
            axis=-1,
        )

    def select(self, individuals: NDArray[np.intp]) -> "Rhythm":
        """Return the rhythms of some individuals."""
        names = "frequency duty offset centre stroke path longest gains"
        if self.standing.ndim > 1:
            names += " anchors axes tips standing lower upper weights length"
        return replace(self, **{name: getattr(self, name)[individuals] for name in names.split()})


@dataclass(frozen=True, eq=False)
class Controller:
    """A gait that feels, as an exporter needs it: rhythm and reflexes.

    Attributes:
        rhythm: rhythm of one individual.
        reflexes: reflexes by name in order, with the values of its genes as options.
        states: state of each reflex at the start, arrays (1, …) by name.
        interval: duration of a control step, s.
    """

    rhythm: Rhythm
    reflexes: Mapping[str, Reflex]
    states: Mapping[str, Mapping[str, Floats]]
    interval: float
