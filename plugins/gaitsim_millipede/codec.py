"""Decoding of bits to leg angles, and the reach of a leg at each angle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Genomes
from gaitsim.plugin.toolkit import scalar_sin as sin

LIMIT = 20  # degrees either way, so that legs do not cross
_MAGNITUDE_BITS = 5
# Reaches are whole multiples of this number, so that sums of a thousand of them are exact in any
# order. Opposite legs then cancel to exactly 0, not to a rounding error with a sign.
_RESOLUTION = 2.0**-40


@dataclass(frozen=True)
class Codec:
    """A group of bits for each leg: an optional sign, then 5 bits for whole degrees.

    The sign bit is 1 for backward. Magnitudes above 20 are read as 20, and −0 as 0.
    """

    signed: bool

    @property
    def bits(self) -> int:
        """Number of bits per leg."""
        return _MAGNITUDE_BITS + self.signed

    def labels(self, legs: Sequence[str]) -> tuple[str, ...]:
        """Return the names of all bits: 'L1 sign', 'L1 16', 'L1 8' … 'L1 1', 'L2 sign' …"""
        places = ("sign", "16", "8", "4", "2", "1")[not self.signed :]
        return tuple(f"{leg} {place}" for leg in legs for place in places)

    def repair(self, genomes: Genomes) -> Genomes:
        """Truncate magnitudes above 20 to 20 and keep everything else.

        Args:
            genomes: bits 0 and 1, (population, genes).

        Returns:
            A new array of the same shape and dtype, or `genomes` if no magnitude is above 20.
        """
        # Computed at every bit, as if a magnitude started there: NumPy is six times as fast on
        # contiguous memory as on every sixth bit.
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

        The population is the last axis, so that NumPy's innermost loops are long.

        Args:
            genomes: bits 0 and 1, (population, genes) uint8.

        Returns:
            The codes, (legs, population) uint8.
        """
        # Computed at every bit, as if a leg started there, as in `repair`.
        bits = genomes.reshape(-1)
        length = len(bits) - self.bits + 1
        codes = bits[:length].copy()
        for place in range(1, self.bits):
            codes += codes
            codes += bits[place : place + length]
        return np.ascontiguousarray(codes[:: self.bits].reshape(len(genomes), -1).T)

    @cached_property
    def degrees(self) -> NDArray[np.int64]:
        """Leg angle of each code, (2**bits,), degrees, positive forward."""
        magnitudes = np.minimum(np.arange(2**_MAGNITUDE_BITS), LIMIT)
        return np.concatenate([magnitudes, -magnitudes]) if self.signed else magnitudes

    @cached_property
    def reaches(self) -> NDArray[np.float64]:
        """Motion of a leg for each code, sin θ / sin 20°, (2**bits,), rounded to about 10⁻¹²."""
        sines = np.array([sin(angle) for angle in np.radians(self.degrees)])
        reaches = sines / sin(np.radians(LIMIT))
        rounded: NDArray[np.float64] = np.rint(reaches / _RESOLUTION) * _RESOLUTION
        return rounded


CODECS: Mapping[str, Codec] = {"sign-magnitude": Codec(True), "unsigned": Codec(False)}
