"""Bits to leg angles, and the reach of a leg at each angle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes

LIMIT = 20  # degrees either way, so that legs do not cross
_MAGNITUDE_BITS = 5
# Reaches are whole multiples of this. Sums of a thousand of them are then exact, in any
# order: opposite legs cancel to zero, and a side that stands still has no sign of its own.
_GRAIN = 2.0**-40


@dataclass(frozen=True)
class Codec:
    """A group of bits a leg: a sign where there is one, then 5 bits of whole degrees.

    The sign bit is 1 for backward. A magnitude above 20 means 20, and −0 is 0.

    Args:
        signed: whether there is a sign bit.
    """

    signed: bool

    @property
    def bits(self) -> int:
        """Bits a leg."""
        return _MAGNITUDE_BITS + self.signed

    def labels(self, legs: Sequence[str]) -> tuple[str, ...]:
        """Names of all bits: 'L1 sign', 'L1 16', 'L1 8' … 'L1 1', 'L2 sign' …"""
        places = ("sign", "16", "8", "4", "2", "1")[not self.signed :]
        return tuple(f"{leg} {place}" for leg in legs for place in places)

    def repair(self, genomes: Genomes) -> Genomes:
        """Truncate magnitudes above 20 to 20 and keep everything else.

        Args:
            genomes: (population, genes) of 0 and 1.

        Returns:
            A new array of that shape and dtype.
        """
        repaired = genomes.copy()
        first = int(self.signed)
        sixteen, eight, four, two, one = (
            repaired[:, place :: self.bits] for place in range(first, self.bits)
        )
        over = sixteen & (eight | (four & (two | one)))  # 16 + 4 is 20
        kept = over ^ 1
        eight &= kept
        four |= over
        two &= kept
        one &= kept
        return repaired

    def codes(self, genomes: Genomes) -> NDArray[np.uint8]:
        """Return the bits of each leg as one number, the index into `degrees` and `reaches`.

        The population comes last, so that NumPy's innermost loops are long: 0.11 ms for
        8,000 genomes of 36 bits. Doubling is six times as fast as shifting.

        Args:
            genomes: (population, genes) uint8 of 0 and 1.

        Returns:
            (legs, population).
        """
        groups = np.ascontiguousarray(genomes.T).reshape(-1, self.bits, len(genomes))
        codes = groups[:, 0].copy()
        for place in range(1, self.bits):
            codes += codes
            codes += groups[:, place]
        return codes

    @cached_property
    def degrees(self) -> NDArray[np.int64]:
        """Leg angle by code, (2**bits,), degrees, positive forward."""
        magnitudes = np.minimum(np.arange(2**_MAGNITUDE_BITS), LIMIT)
        return np.concatenate([magnitudes, -magnitudes]) if self.signed else magnitudes

    @cached_property
    def reaches(self) -> NDArray[np.float64]:
        """Motion of a leg, sin θ / sin 20°, by code, (2**bits,), to a part in 10¹²."""
        reaches = np.sin(np.radians(self.degrees)) / np.sin(np.radians(LIMIT))
        grained: NDArray[np.float64] = np.rint(reaches / _GRAIN) * _GRAIN
        return grained


CODECS: Mapping[str, Codec] = {"sign-magnitude": Codec(True), "unsigned": Codec(False)}
