"""Genomes written bit by bit with Python's own formatting, independent of the codec."""

import numpy as np


def encoded(codec, degrees):
    """Return a population of one genome, given the angle of each leg in whole degrees."""
    signs = [str(int(angle < 0)) if codec.signed else "" for angle in degrees]
    texts = [sign + f"{abs(angle):05b}" for sign, angle in zip(signs, degrees, strict=True)]
    return np.array([list(map(int, "".join(texts)))], dtype=np.uint8)
