"""The contract of a fitness function."""

from abc import abstractmethod
from typing import ClassVar

from gaitsim.contracts.motion import Array, Motion
from gaitsim.contracts.plugin import Plugin


class Fitness(Plugin):
    """A fitness function: named terms whose sum is the score; higher is better.

    Attributes:
        needs: names of the channels that the function reads.
        unit: unit of the score and of all its terms, as printed; `''` for pure numbers.
    """

    needs: ClassVar[tuple[str, ...]]
    unit: ClassVar[str] = ""

    @abstractmethod
    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the terms of the scores by name, each an array of shape (population,).

        The names must be the same for every motion. If a term of an individual is not finite, its
        score is −inf, and the run continues.
        """
