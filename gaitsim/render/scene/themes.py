"""Colours of a scene; those of markers suit colour-blind readers (Okabe & Ito 2008)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Colour = NDArray[np.float64]
"""Red, green, blue, each 0 to 1, (3,)."""


@dataclass(frozen=True)
class Theme:
    """The colours of a scene, as '#rrggbb'.

    Attributes:
        ground: the ground and the background.
        grid: lines on the ground.
        ink: text.
        faint: text of less weight, and lines between panels.
        shadow: of the body on the ground.
        limb, limb_light, limb_edge: a limb's side, its light upper side, its outline.
        body, body_light: the same of trunks, plates and solids.
        stance, swing: feet on the ground and in the air.
        path: of the body.
    """

    ground: str
    grid: str
    ink: str
    faint: str
    shadow: str
    limb: str
    limb_light: str
    limb_edge: str
    body: str
    body_light: str
    stance: str
    swing: str
    path: str

    @property
    def colours(self) -> dict[str, Colour]:
        """Its colours by name."""
        from matplotlib.colors import to_rgb

        return {name: np.array(to_rgb(colour)) for name, colour in vars(self).items()}

    @property
    def exact(self) -> NDArray[np.uint8]:
        """Its colours, (colours, 3), 0 to 255."""
        return np.round(255 * np.array([*self.colours.values()])).astype(np.uint8)


THEMES = {
    "light": Theme(
        ground="#f6f4ef",
        grid="#93a0ad",
        ink="#1c252e",
        faint="#6a7682",
        shadow="#d9d6cf",
        limb="#43586b",
        limb_light="#7d94a8",
        limb_edge="#1b2631",
        body="#2f6f8f",
        body_light="#5b9dbd",
        stance="#d55e00",
        swing="#0072b2",
        path="#009e73",
    ),
    "dark": Theme(
        ground="#12161c",
        grid="#55637a",
        ink="#eef1f5",
        faint="#8d99a8",
        shadow="#07090c",
        limb="#8396aa",
        limb_light="#c6d2de",
        limb_edge="#05070a",
        body="#3f86a8",
        body_light="#84c3e0",
        stance="#e69f00",
        swing="#56b4e9",
        path="#2fc79b",
    ),
}


def mixed(one: Colour, other: Colour, share: Any) -> NDArray[np.float64]:
    """Mix `one` with a share, a number or (…), of `other`; return (…, 3)."""
    share = np.asarray(share)[..., None]
    return np.asarray(one * (1 - share) + other * share)
