"""The contract of a body."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from gaitsim.contracts.motion import Array, Channel, Measure, Motion, Skeleton
from gaitsim.contracts.plugin import Plugin
from gaitsim.contracts.space import Genomes, GenomeSpace
from gaitsim.errors import GaitsimError


class Organism(Plugin):
    """A body and the encoding that turns a genome into movement.

    Attributes:
        channels: the channels of its motion by name. By convention the channel `joint_angles`,
            `Channel(("frames", "joints"), "rad", …)`, is what a robot can play, with `joint_names`
            beside it.
        threads: whether moving and judging release the interpreter's lock for most of
            their time, as compiled kernels can, so that threads share the work. A body
            written in Python leaves it False and is shared among processes.
        dynamic: whether forces move it, so that it falls where nothing holds it. What a body
            without inertia would do only by an exploit, such as a leap, is then earned.
    """

    channels: ClassVar[Mapping[str, Channel]]
    threads: ClassVar[bool] = False
    dynamic: ClassVar[bool] = False

    @abstractmethod
    def genome_space(self) -> GenomeSpace:
        """The genomes that this body, with these options, understands."""

    @abstractmethod
    def move(self, genomes: Genomes) -> Motion:
        """Move a whole population: (population, genes) -> motion.

        Each individual's motion depends on its own genome alone, to the bit, so
        that populations can be cut into chunks.
        """

    def play(self, joint_angles: Array) -> Motion:
        """Move by joint angles that did not come from a genome, such as a network's or a file's.

        Optional: a body that has the channel `joint_angles` and can follow any course of
        them defines it. Measures, skeleton and fitness work on what it returns as on what
        `move` does.

        Args:
            joint_angles: (population, frames, joints), radians. It stays as it is.

        Returns:
            The motion. Its channel `joint_angles` is what was played: where the body has
            limits of angle or speed, what is asked beyond them is held to them.

        Raises:
            GaitsimError: this body cannot.
        """
        raise GaitsimError(
            f"the body {type(self).__name__} cannot play joint angles",
            allowed="a body with the method play()",
        )

    @property
    def can_play(self) -> bool:
        """Whether the body can play given joint angles: whether it defines `play`."""
        return type(self).play is not Organism.play

    @abstractmethod
    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """The body of one individual over time, to draw; of several trials, the first."""

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """How far, how steady, how clean each individual moved, for people. None by default."""
        return {}

    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints of the channel `joint_angles`; empty where there is none."""
        return ()
