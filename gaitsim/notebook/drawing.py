"""An individual at a moment, as an image."""

from typing import TYPE_CHECKING

from gaitsim.errors import unknown
from gaitsim.individual import Individual

if TYPE_CHECKING:
    from PIL.Image import Image


def picture(
    individual: Individual,
    seconds: float = 0.0,
    *,
    view: str = "iso",
    size: tuple[int, int] = (640, 360),
    dark: bool = False,
) -> "Image":
    """Draw the body of an individual at a moment, as an image; a notebook shows it.

    Args:
        individual: such as a run's champion.
        seconds: since the motion began.
        view: 'iso' obliquely from the front, 'side', 'top'.
        size: width and height, pixels.
        dark: whether the ground is dark.

    Raises:
        GaitsimError: there is no such view.
        PluginError: the body cannot be drawn.
    """
    from PIL import Image

    from gaitsim.render.scene import VIEWS, draw

    if view not in VIEWS:
        raise unknown("view", view, VIEWS)
    theme = "dark" if dark else "light"
    return Image.fromarray(draw(individual.skeleton, seconds, size=size, view=view, theme=theme))
