"""The millipede: pairs of stiff legs along a spine that reach and then straighten."""

import math
from collections.abc import Mapping
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from gaitsim.plugin import (
    Array,
    BitSpace,
    Channel,
    Genomes,
    GenomeSpace,
    Measure,
    Motion,
    Organism,
    Skeleton,
    option,
)
from gaitsim.plugin.toolkit import arcsin, cos, scalar, sin
from gaitsim_millipede import cycle
from gaitsim_millipede.codec import CODECS, LIMIT, Codec
from gaitsim_millipede.fitness import clockwise_motion, forward_motion

_SIN_LIMIT = float(scalar.sin(math.radians(LIMIT)))
SIDES = ("left", "right")


class Millipede(Organism):
    """A millipede with pairs of legs along a stiff spine, which reach and then straighten.

    The genome gives each leg one angle, up to 20° forward or backward from square to the spine. In
    each cycle, all legs lift and reach to this angle while the spine rests on the ground; then they
    straighten on the ground and carry the body (Shores 2012).
    """

    pairs: int = option(3, "number of pairs of legs", ge=1, le=1000)
    codec: Literal["sign-magnitude", "unsigned"] = option(
        "sign-magnitude",
        "encoding of a leg's angle: 'sign-magnitude' is a sign and 5 bits of degrees; "
        "'unsigned' is 5 bits that reach only forward",
    )
    leg_length: float = option(0.05, "length of a leg", unit="m", ge=1e-4, le=10)
    leg_spacing: float = option(
        0.04, "distance along the spine from one leg to the next", unit="m", ge=1e-4, le=10
    )
    spine: float | None = option(
        None,
        "length of the spine; none for one leg spacing per pair of legs",
        unit="m",
        ge=1e-4,
        le=10_000,
    )

    # Moving a population of 79 takes less time than handing it to a thread.
    portable: ClassVar[bool] = True
    threads: ClassVar[bool] = False
    channels: ClassVar[Mapping[str, Channel]] = {
        "side_reach": Channel((SIDES,), "", "motion of a side per cycle; 1 is the largest"),
        "sides": Channel((SIDES,), "m", "motion of a side per cycle"),
        "leg_angles": Channel(("feet",), "rad", "leg angles at full reach, positive forward"),
        "joint_angles": Channel(("frames", "joints"), "rad", "swing and lift of each leg"),
        "pose": Channel(
            ("frames", ("x", "y", "yaw")), ("m", "m", "rad"), "pose of the body in the world"
        ),
        "stance": Channel(
            ("frames", "feet"), "", "whether the foot stays in place until the next frame"
        ),
    }

    @model_validator(mode="after")
    def _check(self) -> Self:
        needed = (self.pairs - 1) * self.leg_spacing
        if self._spine_length < needed * (1 - 1e-9):  # 3 × 0.1 m fit on 0.3 m despite rounding
            raise ValueError(
                f"a spine of {self.spine:g} m is too short for {self.pairs} pairs of legs "
                f"{self.leg_spacing:g} m apart, which need {needed:g} m"
            )
        return self

    @property
    def _spine_length(self) -> float:
        return self.pairs * self.leg_spacing if self.spine is None else self.spine

    @property
    def _codec(self) -> Codec:
        return CODECS[self.codec]

    @property
    def _legs(self) -> tuple[str, ...]:
        """Names of the legs, L1 L2 … R1 R2 …, front to back."""
        return tuple(f"{side}{pair}" for side in "LR" for pair in range(1, self.pairs + 1))

    def genome_space(self) -> GenomeSpace:
        """Return the space of 6 bits per leg, or 5 if unsigned; left legs, then right legs."""
        return BitSpace(self._codec.labels(self._legs), self._codec.repair)

    def joint_names(self) -> tuple[str, ...]:
        """Return 'L1 swing', 'L1 lift', 'L2 swing' … 'R3 lift'."""
        return tuple(f"{leg} {joint}" for leg in self._legs for joint in ("swing", "lift"))

    def move(self, genomes: Genomes) -> Motion:
        """Decode genomes to the reach of both sides; other channels are computed on first use.

        8,000 millipedes with 6 legs take 0.19 ms on one core; 79 take 11 µs.
        """
        codes = self._codec.codes(genomes)
        reaches = self._codec.reaches.take(codes).reshape(2, self.pairs, len(genomes))
        reach = reaches.sum(axis=1).T / self.pairs

        def sides() -> dict[str, Array]:
            return {"sides": self.leg_length * _SIN_LIMIT * reach}

        def leg_angles() -> dict[str, Array]:
            return {"leg_angles": np.radians(self._codec.degrees)[codes.T]}

        def joint_angles() -> dict[str, Array]:
            angles = np.zeros((len(genomes), cycle.FRAMES, 2 * self.pairs, 2), dtype=np.float32)
            # The sine follows `EXTENT`, not the angle, so that feet on the ground do not slip along
            # the body's path.
            sines = sin(motion["leg_angles"])[:, None] * cycle.EXTENT[:, None]
            angles[..., 0] = arcsin(sines)
            angles[..., 1] = cycle.LIFTED[:, None]
            return {"joint_angles": angles.reshape(*angles.shape[:2], -1)}

        def pose() -> dict[str, Array]:
            pose = np.zeros((len(genomes), cycle.FRAMES, 3))
            pose[..., 0] = forward_motion(motion["sides"])[:, None] * cycle.PROGRESS
            pose[..., 2] = self._turn(reach)[:, None] * cycle.PROGRESS
            return {"pose": pose}

        def stance() -> dict[str, Array]:
            shape = (len(genomes), cycle.FRAMES, 2 * self.pairs)
            return {"stance": np.broadcast_to(cycle.STANCE[:, None], shape).copy()}

        motion = Motion(
            cycle.FRAME_RATE,
            {"side_reach": reach},
            {
                ("sides",): sides,
                ("leg_angles",): leg_angles,
                ("joint_angles",): joint_angles,
                ("pose",): pose,
                ("stance",): stance,
            },
        )
        return motion

    def _turn(self, reach: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the yaw per cycle, (population,), radians, positive to the left.

        The paths of the two sides differ by the yaw times the distance of their feet, which is two
        leg lengths.
        """
        return 0 - clockwise_motion(reach) * (_SIN_LIMIT / 2)

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return travel, travel and turn per stride, mean leg angles, and crossing legs.

        A stride is a cycle of reaching and straightening. Its length over the length of the legs is
        the relative stride length (Alexander 1989, Physiological Reviews 69:1199).
        """
        stride = forward_motion(motion["sides"])
        turned = np.degrees(self._turn(motion["side_reach"]))
        degrees = np.degrees(motion["leg_angles"]).reshape(-1, 2, self.pairs).mean(axis=2)
        return {
            "forward": Measure(
                stride * cycle.PROGRESS[-1], "m", f"displacement in {cycle.CYCLES} strides"
            ),
            "stride length": Measure(stride, "m", "displacement per cycle of the legs"),
            "relative stride": Measure(
                stride / self.leg_length, "", "stride length in leg lengths"
            ),
            "turn per stride": Measure(turned, "°", "turn to the left"),
            "left legs": Measure(degrees[:, 0], "°", "mean angle of the left legs at full reach"),
            "right legs": Measure(degrees[:, 1], "°", "mean angle of the right legs at full reach"),
            "crossings": Measure(
                self._crossings(motion["leg_angles"]), "", "neighbouring legs that would cross"
            ),
        }

    def _crossings(self, angles: Array) -> Array:
        """Return the number of neighbouring legs that cross at full reach, (population,)."""
        sides = angles.reshape(-1, 2, self.pairs)
        front, rear = sides[..., :-1], sides[..., 1:]
        # By the law of sines, the longer distance from a hip to the crossing of two legs is
        # spacing × the larger cosine / sin (rear − front).
        longer = self.leg_spacing * np.maximum(cos(front), cos(rear))
        crossing = longer <= self.leg_length * sin(rear - front)
        return np.asarray(crossing.sum(axis=(1, 2)))

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return spine and legs in the world, flat on the ground except for lifted legs."""
        angles = motion["joint_angles"][individual].astype(np.float64)
        swing, lift = angles.reshape(cycle.FRAMES, 2, self.pairs, 2).transpose(3, 0, 1, 2)
        hips = self.leg_spacing * ((self.pairs - 1) / 2 - np.arange(self.pairs))
        segments = np.zeros((cycle.FRAMES, 1 + 2 * self.pairs, 2, 3))
        segments[:, 0, :, 0] = self._spine_length / 2 * np.array([1, -1])
        legs = segments[:, 1:].reshape(cycle.FRAMES, 2, self.pairs, 2, 3)
        outward = np.array([1.0, -1.0])[:, None]  # left, right
        legs[..., 0] = hips[:, None]
        legs[..., 1, 0] += self.leg_length * cos(lift) * sin(swing)
        legs[..., 1, 1] = self.leg_length * cos(lift) * cos(swing) * outward
        legs[..., 1, 2] = self.leg_length * sin(lift)
        world = _to_world(segments, motion["pose"][individual])
        return Skeleton(
            segments=world,
            names=("spine", *self._legs),
            frame_rate=motion.frame_rate,
            contacts=world[:, 1:, 1],
            touching=motion["stance"][individual],
            contact_names=self._legs,
        )


def _to_world(points: NDArray[np.float64], pose: Array) -> NDArray[np.float64]:
    """Transform points from the body's frame, (frames, …, 3), to the world frame."""
    x, y, yaw = pose.T[:, :, None, None]
    c, s = cos(yaw), sin(yaw)
    world = points.copy()
    world[..., 0] = x + c * points[..., 0] - s * points[..., 1]
    world[..., 1] = y + s * points[..., 0] + c * points[..., 1]
    return world
