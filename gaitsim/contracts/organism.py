"""The contract of a body."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from gaitsim.contracts.motion import Measure, Motion, Skeleton
from gaitsim.contracts.plugin import Plugin
from gaitsim.contracts.space import Genomes, GenomeSpace


class Organism(Plugin):
    """A body and the encoding that turns a genome into movement.

    Attributes:
        channels: what each channel of its motion holds, with shape and unit. By
            convention a channel `joint_angles`, (population, frames, joints) in
            radians, is what a robot can play, with `joint_names` beside it.
        threads: whether moving and judging release the interpreter's lock for most of
            their time, as compiled kernels can, so that threads share the work. A body
            written in Python leaves it False and is shared among processes.
    """

    channels: ClassVar[Mapping[str, str]]
    threads: ClassVar[bool] = False

    @abstractmethod
    def genome_space(self) -> GenomeSpace:
        """The genomes that this body, with these options, understands."""

    @abstractmethod
    def move(self, genomes: Genomes) -> Motion:
        """Move a whole population: (population, genes) -> motion.

        Each individual's motion depends on its own genome alone, to the bit, so
        that populations can be cut into chunks.
        """

    @abstractmethod
    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """The body of one individual over time, to draw."""

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """How far, how steady, how clean each individual moved, for people. None by default."""
        return {}

    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints of the channel `joint_angles`; empty where there is none."""
        return ()
