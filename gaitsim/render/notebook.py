"""Pictures, pages and figures of individuals, for Python and notebooks."""

from html import escape
from typing import TYPE_CHECKING, Any

from gaitsim.contracts import Exporter, Subject
from gaitsim.errors import GaitsimError, unknown
from gaitsim.individual import Individual

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image

    from gaitsim.render.plots.style import Theme

DOTS_PER_INCH = 150  # resolution of a figure in a notebook


def picture(
    shown: Any,
    seconds: float = 0.0,
    *,
    view: str = "iso",
    size: tuple[int, int] = (640, 360),
    dark: bool = False,
) -> "Image":
    """Draw the body of an individual at a moment, as an image that notebooks show.

    Args:
        shown: an individual; or a run or a search, for its champion.
        seconds: time since the motion began.
        view: 'iso' (from a front corner and above), 'side' or 'top'.
        size: width and height, pixels.
        dark: whether the background is dark.

    Raises:
        GaitsimError: `shown` is something else, or the view is unknown.
        PluginError: the body cannot be drawn.
    """
    from PIL import Image

    from gaitsim.render.scene import VIEWS, draw

    if view not in VIEWS:
        raise unknown("view", view, VIEWS)
    theme = "dark" if dark else "light"
    skeleton = _individual(shown).skeleton
    return Image.fromarray(draw(skeleton, seconds, size=size, view=view, theme=theme))


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


def view(*shown: Any, height: int = 560) -> View:
    """Return a page that plays individuals in 3D, side by side, in a notebook.

    Args:
        *shown: one or more individuals, such as `run.replay(1), run.champion`; or runs or
            searches, for their champions.
        height: height of the frame, pixels.

    Raises:
        GaitsimError: no individual is given, too many, or something else.
        PluginError: a body cannot be moved, drawn or measured.
    """
    if not shown:
        raise GaitsimError(
            "view() was called without an individual", allowed="one or more individuals"
        )
    subject = Subject(None, tuple(map(_individual, shown)))
    return View(page_exporter().embedded(subject), height)


def _individual(shown: Any) -> Individual:
    found = getattr(shown, "champion", shown)
    if isinstance(found, Individual):
        return found
    raise GaitsimError(
        f"a {type(found).__name__} is not an individual",
        allowed="an individual, such as run.replay(3); or a run or a search, for its champion",
    )


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
