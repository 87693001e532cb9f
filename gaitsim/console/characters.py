"""Colour character graphics with the sixteen colours of the terminal."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from gaitsim.render.terminal.braille import Inks, ink_runs

_SIDES = ("white", "cyan", "yellow")  # middle, left, right, as in the footfall diagram
# Styles by ink: none, ground, track, limbs from far to near, damage, feet, labels.
BODY = (
    "",
    "bright_black",
    "green",
    *(f"{fog}{side}" for fog in ("dim ", "", "bold ") for side in _SIDES),
    "bold red",
    *(f"bold {side}" for side in _SIDES),
    "default",
)
LINES = ("cyan", "yellow", "green", "red", "white", "blue")  # colours of curves, in order


def lines(codes: NDArray[np.uint32], inks: Inks, styles: Sequence[str]) -> list[Text]:
    """Return one coloured line of text per row.

    Args:
        codes: characters as code points, (rows, columns).
        inks: ink of each character, (rows, columns).
        styles: Rich style of each ink.
    """
    return [
        Text.assemble(
            *((text, styles[ink]) for text, ink in ink_runs(row, own)), no_wrap=True, end=""
        )
        for row, own in zip(codes, inks, strict=True)
    ]
