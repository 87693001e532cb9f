"""The contract of a body."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from gaitsim.contracts.condition import Condition
from gaitsim.contracts.motion import Array, Channel, Measure, Motion, Skeleton
from gaitsim.contracts.plugin import Plugin
from gaitsim.contracts.rig import Rig
from gaitsim.contracts.space import Genomes, GenomeSpace
from gaitsim.contracts.steering import Command, Steered, SteeringPage
from gaitsim.errors import GaitsimError

Facts = Mapping[str, Mapping[str, str]]
"""Facts to show to people: values by name, below headings. A value may be ''."""


@dataclass(frozen=True)
class BodyFile:
    """A body that was read from a file.

    Attributes:
        name: name of the body.
        text: content that the option stores in place of the file's path.
        repairs: one line for each part of the file that the reader dropped, replaced, added or
            assumed.
    """

    name: str
    text: str
    repairs: tuple[str, ...] = ()


class Organism(Plugin):
    """A body and the encoding that turns a genome into movement.

    Attributes:
        channels: channels of the body's motion by name. A robot can play the channel
            `joint_angles`, `Channel(("frames", "joints"), "rad", …)`, whose joints
            `joint_names()` names.
        threads: whether `move` and the evaluation release the global interpreter lock most of the
            time, as compiled kernels can. The work is then shared among threads; otherwise among
            processes. False is right for a body written in Python.
        dynamic: whether the body moves by forces, so that it falls without support. A leap is
            then legitimate; for a body without inertia it is an exploit.
        twin: preset whose body is the same one in rigid-body physics. Its joints have the same
            names and zeros, so that it can play this body's gaits. '' for none.
    """

    channels: ClassVar[Mapping[str, Channel]]
    threads: ClassVar[bool] = False
    dynamic: ClassVar[bool] = False
    twin: ClassVar[str] = ""

    @abstractmethod
    def genome_space(self) -> GenomeSpace:
        """Return the genome space of this body with its options."""

    @abstractmethod
    def move(self, genomes: Genomes) -> Motion:
        """Move a whole population: (population, genes) -> motion.

        The motion of each individual must depend on its own genome alone, bit for bit, because
        populations are split into chunks.
        """

    def play(self, joint_angles: Array) -> Motion:
        """Move a population by given joint angles, such as those of a network or a file.

        Optional, for bodies with the channel `joint_angles` that can follow given angles.
        Measures, skeleton and fitness accept the result as they accept that of `move`.

        Args:
            joint_angles: (population, frames, joints), radians. The body must not change the
                array.

        Returns:
            The motion. Its channel `joint_angles` holds the angles as played, within the body's
            limits of angle and speed.

        Raises:
            GaitsimError: the body cannot play joint angles.
        """
        raise GaitsimError(
            f"the body {type(self).__name__} cannot play joint angles",
            allowed="a body with the method play()",
        )

    @property
    def can_play(self) -> bool:
        """Whether the body defines `play`."""
        return type(self).play is not Organism.play

    @abstractmethod
    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return the geometry of one individual, for drawing; of several trials, the first."""

    def rig(self) -> Rig | None:
        """Return the body as a tree of links that its joint angles move; None by default.

        The page of an atlas moves a body with a rig in 3D by its joint angles instead of stored
        points. Its segments, solids and feet are the skeleton's segments, solids and contacts, in
        the same order.
        """
        return None

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return quantities that describe each motion to people; {} by default."""
        return {}

    def conditions(self) -> Mapping[str, Condition]:
        """Return the conditions that may vary between worlds, by name; {} if none do.

        A body with conditions has the option `world: dict[str, float] = option({}, WORLD_HELP)`,
        validates it with `check_world`, and moves and plays in that world.
        """
        return {}

    def describe(self) -> Facts:
        """Return facts about the body with its options, such as its mass and its legs."""
        return {}

    @classmethod
    def library(cls) -> Facts:
        """Return what the package offers for the body's options, such as robots by name."""
        return {}

    @classmethod
    def read_file(cls, path: Path, roots: Sequence[Path] = ()) -> BodyFile:
        """Read a file that describes a body of this class, so that it can be checked.

        Optional, for bodies that register a format as an entry point of the group
        `gaitsim.files`.

        Args:
            path: path of the file.
            roots: further folders that the file may refer to.

        Raises:
            GaitsimError: the file cannot be used, or this body reads no files.
        """
        raise GaitsimError(f"the body {cls.__name__} reads no files", where=str(path))

    def joint_names(self) -> tuple[str, ...]:
        """Return the joints of the channel `joint_angles`; () for a body without the channel."""
        return ()

    def standing_pose(self) -> Array:
        """Return the joint angles in which the body stands at rest, (joints,) rad.

        Files for robots start and end in this pose. The default is zero for every joint; override
        it if the body stands in another pose.
        """
        return np.zeros(len(self.joint_names()))

    def leg_joints(self) -> Mapping[str, tuple[str, ...]]:
        """Return the joints of each leg by the leg's name; {} for a body without legs.

        A body with legs has a measure of the duty factor of each leg, as
        `gaitsim.legged.stepping_measures` computes it; an atlas uses these measures to distinguish
        gaits. If the body has an option `damage`, which `gaitsim.legged.parse_damage` parses, its
        gaits can be adapted to damage.
        """
        return {}

    def commands(self) -> tuple[Command, ...]:
        """Return the commands that a person can give, each with its own key.

        The first command applies while no key is pressed. () for a body that cannot be steered.
        """
        return ()

    def controllers(self) -> Mapping[str, Genomes]:
        """Return the trained controllers of the package: genomes (genes,) by command.

        Controllers suit only the options with which they were trained. Return {} for any other
        genome space, such as that of a larger network.
        """
        return {}

    def steer(self, controllers: Mapping[str, Genomes]) -> Steered:
        """Return the body in its initial state, ready to be steered.

        Args:
            controllers: a genome (genes,) for each of `commands()`, by name.

        Raises:
            GaitsimError: the body cannot be steered, or a controller is missing or does not fit.
        """
        raise GaitsimError(
            f"the body {type(self).__name__} cannot be steered",
            allowed="a body with the methods commands(), controllers() and steer()",
        )

    def steering_page(self, controllers: Mapping[str, Genomes]) -> SteeringPage | None:
        """Return the script and data with which a web page simulates the steered body.

        None, the default, if the body cannot be simulated in a page.

        Args:
            controllers: as for `steer`.
        """
        return None
