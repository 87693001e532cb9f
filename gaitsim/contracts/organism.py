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
"""Facts for people: lines of name and value below headings. A value may be ''."""


@dataclass(frozen=True)
class BodyFile:
    """A body that was read from a file.

    Attributes:
        name: of the body.
        text: what the option that takes the file's path keeps in place of it.
        repairs: what was dropped, replaced, added or assumed in reading, a line each.
    """

    name: str
    text: str
    repairs: tuple[str, ...] = ()


class Organism(Plugin):
    """A body and the encoding that turns a genome into movement.

    Attributes:
        channels: the channels of its motion by name. A robot can play the channel
            `joint_angles`, `Channel(("frames", "joints"), "rad", …)`; `joint_names()` names its
            joints.
        threads: whether moving and evaluating release the interpreter's lock most of the time,
            as compiled kernels can, so that threads share the work. A body written in Python
            leaves it False; processes share its work.
        dynamic: whether forces move it, so that it falls without support. A leap, which is an
            exploit of a body without inertia, is then legitimate.
        twin: preset whose body is this one in rigid-body physics, with joints of the same names
            and the same zero, so that it can play this body's gaits; '' for none.
    """

    channels: ClassVar[Mapping[str, Channel]]
    threads: ClassVar[bool] = False
    dynamic: ClassVar[bool] = False
    twin: ClassVar[str] = ""

    @abstractmethod
    def genome_space(self) -> GenomeSpace:
        """Return the space of genomes for this body with its options."""

    @abstractmethod
    def move(self, genomes: Genomes) -> Motion:
        """Move a whole population: (population, genes) -> motion.

        Each individual's motion depends on its own genome alone, to the bit, so
        that populations can be cut into chunks.
        """

    def play(self, joint_angles: Array) -> Motion:
        """Move by joint angles that did not come from a genome, such as a network's or a file's.

        Optional, for bodies with the channel `joint_angles` that can follow given angles.
        Measures, skeleton and fitness work on its motion as on that of `move`.

        Args:
            joint_angles: (population, frames, joints), radians, which the body must not change.

        Returns:
            The motion. Its channel `joint_angles` holds the angles as played, within the body's
            limits of angle and speed.

        Raises:
            GaitsimError: this body cannot.
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
        """Return the body of one individual over time, to draw; of several trials, the first."""

    def rig(self) -> Rig | None:
        """Return the body as a tree of links that its joint angles place; None without one.

        An atlas page moves a body with a rig in 3D, by joint angles instead of points. The rig has
        the skeleton's segments, solids and contacts, in that order.
        """
        return None

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return quantities that describe each motion to people; none by default."""
        return {}

    def conditions(self) -> Mapping[str, Condition]:
        """Return what may vary between worlds, by name; {} for a body with one world alone.

        A body with conditions has the option `world: dict[str, float] = option({}, WORLD_HELP)`,
        which `check_world` checks, and moves and plays in that world.
        """
        return {}

    def describe(self) -> Facts:
        """Return what the body with its options is made of, such as mass and legs, for people."""
        return {}

    @classmethod
    def library(cls) -> Facts:
        """Return what the package brings for the body's options, such as robots by name."""
        return {}

    @classmethod
    def read_file(cls, path: Path, roots: Sequence[Path] = ()) -> BodyFile:
        """Read a file that describes such a body, for people who check it.

        Optional, for bodies that register a format in the entry points `gaitsim.files`.

        Args:
            path: the file.
            roots: further folders whose files it may use.

        Raises:
            GaitsimError: it cannot be used, or this body reads no files.
        """
        raise GaitsimError(f"the body {cls.__name__} reads no files", where=str(path))

    def joint_names(self) -> tuple[str, ...]:
        """Return the names of the joints of the channel `joint_angles`; empty without it."""
        return ()

    def standing_pose(self) -> Array:
        """Return the joint angles in which the body stands at rest, (joints,) rad; zeros.

        Files for robots begin and end there. A body whose zero is another pose overrides it.
        """
        return np.zeros(len(self.joint_names()))

    def leg_joints(self) -> Mapping[str, tuple[str, ...]]:
        """Return the names of the joints of each leg by its name; {} for a body without legs.

        A body with legs measures the `duty factor` of each, as `gaitsim.legged.stepping` does, by
        which an atlas tells gaits apart. If it has an option `damage`, whose texts
        `gaitsim.legged.parse_damage` reads, its gaits can be adapted to damage.
        """
        return {}

    def commands(self) -> tuple[Command, ...]:
        """Return what a person can tell the body to do, each with a key of its own.

        The first one is in force while no key is pressed. () for a body that nobody can steer.
        """
        return ()

    def controllers(self) -> Mapping[str, Genomes]:
        """Return the trained controllers that come with the package: (genes,) by command.

        They belong to the options with which they were trained; another genome space, such as
        that of a larger network, has none.
        """
        return {}

    def steer(self, controllers: Mapping[str, Genomes]) -> Steered:
        """Return the body at its start, under a person's command.

        Args:
            controllers: a genome (genes,) for each of `commands()`, by name.

        Raises:
            GaitsimError: nobody can steer this body, or a controller is missing or does not fit.
        """
        raise GaitsimError(
            f"the body {type(self).__name__} cannot be steered",
            allowed="a body with the methods commands(), controllers() and steer()",
        )

    def steering_page(self, controllers: Mapping[str, Genomes]) -> SteeringPage | None:
        """Return script and data by which a web page simulates the steered body; None without.

        Args:
            controllers: as for `steer`.
        """
        return None
