"""The colours of a scene."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.colours import (
    DAMAGED_COLOUR,
    DAMAGED_ON_DARK,
    LEFT_COLOUR,
    LEFT_ON_DARK,
    LINES,
    LINES_ON_DARK,
    RIGHT_COLOUR,
    RIGHT_ON_DARK,
)

Colour = NDArray[np.float64]
"""Red, green, blue, each 0 to 1, (3,)."""


@dataclass(frozen=True)
class SceneTheme:
    """The colours of a scene, as '#rrggbb'.

    Attributes:
        ground: colour of the ground and the background.
        grid: colour of the lines on the ground.
        ink: colour of text.
        faint: colour of less important text.
        shadow: colour of the body's shadow on the ground.
        limb, limb_light, limb_edge: colours of a limb's side, lit upper side and outline.
        middle, left, right: colours of feet, by side.
        damaged: colour of damaged limbs and of the crosses of lost legs.
        bodies: colours of the trunk, the plates and the path, one for each body.
    """

    ground: str
    grid: str
    ink: str
    faint: str
    shadow: str
    limb: str
    limb_light: str
    limb_edge: str
    middle: str
    left: str
    right: str
    damaged: str
    bodies: tuple[str, ...]

    def body(self, number: int) -> str:
        """Return the colour of a body by its number, counted from 0."""
        return self.bodies[number % len(self.bodies)]

    @property
    def exact(self) -> NDArray[np.uint8]:
        """All colours of the theme, (colours, 3), 0 to 255."""
        named = [value for value in vars(self).values() if isinstance(value, str)]
        every = [rgb(colour) for colour in (*named, *self.bodies)]
        return np.round(255 * np.array(every)).astype(np.uint8)


THEMES = {
    "light": SceneTheme(
        ground="#f6f4ef",
        grid="#93a0ad",
        ink="#1c252e",
        faint="#6a7682",
        shadow="#d9d6cf",
        limb="#5b656f",
        limb_light="#97a2ad",
        limb_edge="#1b2631",
        middle="#1c252e",
        left=LEFT_COLOUR,
        right=RIGHT_COLOUR,
        damaged=DAMAGED_COLOUR,
        bodies=LINES,
    ),
    "dark": SceneTheme(
        ground="#12161c",
        grid="#55637a",
        ink="#eef1f5",
        faint="#8d99a8",
        shadow="#07090c",
        limb="#8b949e",
        limb_light="#cbd3db",
        limb_edge="#05070a",
        middle="#eef1f5",
        left=LEFT_ON_DARK,
        right=RIGHT_ON_DARK,
        damaged=DAMAGED_ON_DARK,
        bodies=LINES_ON_DARK,
    ),
}


def rgb(colour: str) -> Colour:
    """Return the red, green and blue of a colour, 0 to 1, (3,)."""
    from matplotlib.colors import to_rgb

    return np.array(to_rgb(colour))


def mix(one: Colour, other: Colour, share: Any) -> NDArray[np.float64]:
    """Mix `one` with a share of `other`, a number or an array (…); return (…, 3)."""
    share = np.asarray(share)[..., None]
    return np.asarray(one * (1 - share) + other * share)
