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
            A new array of that shape and dtype; `genomes` where no magnitude is above 20.
        """
        # At every bit as if a magnitude began there: neighbours in memory, which NumPy handles
        # six times as fast as every sixth bit.
        bits, first = genomes.reshape(-1), int(self.signed)
        over = bits[3:-1] | bits[4:]
        over &= bits[2:-2]
        over |= bits[1:-3]
        over &= bits[:-4]
        over = over[first :: self.bits].reshape(len(genomes), -1)  # 16 + 4 is 20
        if not over.any():
            return genomes
        repaired, kept = genomes.copy(), over ^ 1
        repaired[:, first + 1 :: self.bits] &= kept
        repaired[:, first + 2 :: self.bits] |= over
        repaired[:, first + 3 :: self.bits] &= kept
        repaired[:, first + 4 :: self.bits] &= kept
        return repaired

    def codes(self, genomes: Genomes) -> NDArray[np.uint8]:
        """Return the bits of each leg as one number, the index into `degrees` and `reaches`.

        The population comes last, so that NumPy's innermost loops are long.

        Args:
            genomes: (population, genes) uint8 of 0 and 1.

        Returns:
            (legs, population).
        """
        # At every bit as if a leg began there, as in `repair`.
        bits = genomes.reshape(-1)
        length = len(bits) - self.bits + 1
        codes = bits[:length].copy()
        for place in range(1, self.bits):
            codes += codes
            codes += bits[place : place + length]
        return np.ascontiguousarray(codes[:: self.bits].reshape(len(genomes), -1).T)

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
