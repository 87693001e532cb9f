"""Pictures, pages and figures of individuals, for Python and notebooks."""

from html import escape
from typing import TYPE_CHECKING

from gaitsim.contracts import Exporter, Subject
from gaitsim.errors import GaitsimError, unknown
from gaitsim.individual import Individual

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image

    from gaitsim.render.plots.style import Theme

DOTS_PER_INCH = 150  # resolution of a figure in a notebook


def picture(
    individual: Individual,
    seconds: float = 0.0,
    *,
    view: str = "iso",
    size: tuple[int, int] = (640, 360),
    dark: bool = False,
) -> "Image":
    """Draw the body of an individual at a moment, as an image that notebooks show.

    Args:
        individual: an individual, such as a run's champion.
        seconds: time since the motion began.
        view: 'iso' (from a front corner and above), 'side' or 'top'.
        size: width and height, pixels.
        dark: whether the background is dark.

    Raises:
        GaitsimError: the view is unknown.
        PluginError: the body cannot be drawn.
    """
    from PIL import Image

    from gaitsim.render.scene import VIEWS, draw

    if view not in VIEWS:
        raise unknown("view", view, VIEWS)
    theme = "dark" if dark else "light"
    return Image.fromarray(draw(individual.skeleton, seconds, size=size, view=view, theme=theme))


class View:
    """A page that plays individuals, returned by `view` and shown by notebooks.

    Attributes:
        page: the page, HTML in UTF-8.
        height: height of its frame in a notebook, pixels.
    """

    def __init__(self, page: bytes, height: int) -> None:
        self.page = page
        self.height = height

    def _repr_html_(self) -> str:
        # A sandboxed frame has its own origin and no access to the notebook.
        return (
            f'<iframe sandbox="allow-scripts" srcdoc="{escape(self.page.decode())}" '
            f'title="A gait in 3D" allow="fullscreen" '
            f'style="width: 100%; height: {self.height}px; border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"View({len(self.page):,} bytes of HTML, for notebooks)"


def view(*individuals: Individual, height: int = 560) -> View:
    """Return a page that plays individuals in 3D, side by side, in a notebook.

    Args:
        *individuals: one or more individuals, such as `run.replay(1), run.champion`.
        height: height of the frame, pixels.

    Raises:
        GaitsimError: no individual is given, or too many.
        PluginError: a body cannot be moved, drawn or measured.
    """
    if not individuals:
        raise GaitsimError(
            "view() was called without an individual", allowed="one or more individuals"
        )
    return View(page_exporter().embedded(Subject(None, individuals)), height)


def page_exporter() -> Exporter:
    from gaitsim.registry.loading import load_product

    exporter = load_product("exporter", "html", {})
    assert isinstance(exporter, Exporter)
    return exporter


def enable_notebook_display(figure: "Figure", theme: "Theme") -> "Figure":
    """Make notebooks show a figure as a picture; return the figure."""
    from gaitsim.render.plots.style import picture

    # Notebooks show pyplot's figures by default, but pyplot keeps each figure until it is closed.
    figure._repr_png_ = lambda: picture(figure, "png", theme, DOTS_PER_INCH)  # type: ignore[attr-defined]
    return figure
