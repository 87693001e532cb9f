"""The colours of plots, videos and the terminal, and the side of a part by its name.

Blue means left and orange means right. A filled mark shows a foot on the ground, a hollow one a
foot in the air. Green, the first colour of lines, shows the body and its path. Compared individuals
and other lines have the next colours, none of which is blue or orange. Crimson means damaged. Blue,
orange, green and pink are from Okabe and Ito (2008), wine and olive from Tol's muted scheme;
colour-blind readers can distinguish them.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

MIDDLE, LEFT, RIGHT = range(3)
# The camera is on the body's right, which is therefore the near side of a planar body.
_SIDES = {
    **dict.fromkeys(("L", "left", "far"), LEFT),
    **dict.fromkeys(("R", "right", "near"), RIGHT),
}

LEFT_COLOUR, RIGHT_COLOUR = "#0072B2", "#D55E00"
DAMAGED_COLOUR = "#D4004F"
LINES = ("#009E73", "#882255", "#1A1A1A", "#CC79A7", "#999933")
# For dark backgrounds.
LEFT_ON_DARK, RIGHT_ON_DARK = "#56B4E9", "#E69F00"
DAMAGED_ON_DARK = "#FF4D88"
LINES_ON_DARK = ("#2FC79B", "#D67BB3", "#FFFFFF", "#8A63C9", "#F3EE9B")


@lru_cache(16)
def sides(names: tuple[str, ...]) -> NDArray[np.intp]:
    """Return the side that the first word of each name gives, such as left for 'L1 femur'.

    A skeleton has no other information on sides. Names without a side are in the middle.
    """
    return np.array([_SIDES.get(_word(name), MIDDLE) for name in names], np.intp)


def is_damaged(names: Sequence[str], damaged: Sequence[str]) -> NDArray[np.bool_]:
    """Return whether each name is in `damaged`."""
    return np.array([name in damaged for name in names], np.bool_)


def side_words(names: Sequence[str]) -> dict[int, str]:
    """Return the words for the sides that occur in names: left and right, or near and far."""
    whole = {"L": "left", "R": "right"}
    found = {_SIDES[word]: whole.get(word, word) for word in map(_word, names) if word in _SIDES}
    return dict(sorted(found.items()))


def _word(name: str) -> str:
    word = name.replace("_", " ").replace("-", " ").partition(" ")[0]
    return word.rstrip("0123456789")
