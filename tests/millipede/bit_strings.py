"""Genomes written out bit by bit, with Python's own formatting rather than the codec's tables."""

import numpy as np


def encoded(codec, degrees):
    """Whole degrees, one a leg, as a population of one genome."""
    signs = [str(int(angle < 0)) if codec.signed else "" for angle in degrees]
    texts = [sign + f"{abs(angle):05b}" for sign, angle in zip(signs, degrees, strict=True)]
    return np.array([list(map(int, "".join(texts)))], dtype=np.uint8)
