"""Pictures, plots and videos of individuals and runs, for Python and notebooks."""

import warnings
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gaitsim.contracts import Exporter, Plot, Subject
from gaitsim.errors import GaitsimError, unknown
from gaitsim.individual import Individual, Which
from gaitsim.runs.snapshot import RunSnapshot

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
    return View(_page_exporter().embedded(Subject(None, individuals)), height)


def _page_exporter() -> Exporter:
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


class RunViews:
    """A run on disk, with methods that plot, film and display it."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def snapshot(self) -> RunSnapshot:
        """The current state of the run; each of its files is read at most once."""
        return RunSnapshot(self.path)

    def plot(
        self,
        kind: str = "fitness",
        *,
        generations: Sequence[Which] = (),
        dark: bool = False,
        **options: Any,
    ) -> "Figure":
        """Return a plot, like the command `gaitsim plot`.

        Args:
            kind: a kind listed by `gaitsim plot --help`, such as 'fitness' or 'footfall'.
            generations: generations whose best individuals to draw, or members such as
                `gs.Member(3)`; () for the champion.
            dark: whether the background is dark.
            **options: options of the kind, such as `channel`, `components` (a sequence of names),
                `window` (start and end in seconds), `beside` (names or folders of other runs) and
                `axes` (two axes of an archive); `gaitsim plugins show KIND` lists them.

        Returns:
            The figure, which notebooks show and `savefig` writes.

        Raises:
            GaitsimError: the kind or an option is unknown, or the run or its body lacks the data.
        """
        from gaitsim.registry.loading import load_product
        from gaitsim.render.plots.style import THEMES

        plot = load_product("plot", kind, options | ({"theme": "dark"} if dark else {}))
        assert isinstance(plot, Plot)
        run = self.snapshot
        individuals: tuple[Individual, ...] = ()
        if plot.input != "run":
            individuals = tuple(run.individual(one) for one in generations or (None,))
        return enable_notebook_display(plot.draw(Subject(run, individuals)), THEMES[plot.theme])

    def video(
        self,
        path: str | Path,
        *,
        generations: Sequence[Which] = (),
        view: str = "iso",
        size: tuple[int, int] | None = None,
        fps: float | None = None,
        speed: float | None = None,
        dark: bool = False,
        intro: bool = True,
    ) -> Path:
        """Write an MP4 or GIF, depending on the file's extension, like `gaitsim video`.

        Args:
            path: path of the file.
            generations: generations whose best individuals to show, or members such as
                `gs.Member(3)`; several run a race. () shows the champion.
            view: 'iso', 'side', 'top' or 'orbit'.
            size: width and height, pixels.
            fps: frames per second.
            speed: speed of the motion, where 1 is real time. None chooses real time, or slow motion
                for movements too fast for the frame rate, such as a wing beat.
            dark: whether the background is dark.
            intro: whether the video begins with the fitness curve.

        Returns:
            The path of the file.

        Raises:
            GaitsimError: an argument is invalid, or the file cannot be written.
        """
        from gaitsim.render.film import RenderSettings
        from gaitsim.render.video import Video

        path = Path(path)
        theme = "dark" if dark else "light"
        settings = RenderSettings(path.suffix[1:].lower(), size, fps, speed, view, theme, intro)
        video = Video(self.snapshot, generations, settings)
        if video.warning:
            warnings.warn(video.warning, stacklevel=2)
        video.write(path)
        return path

    def page(self, path: str | Path, *, generations: Sequence[Which] = ()) -> Path:
        """Write a page that plays champions in any browser, like `gaitsim export --format html`.

        Args:
            path: path of the file.
            generations: generations whose best individuals to show, or members such as
                `gs.Member(3)`; several are shown side by side. () shows the champion.

        Returns:
            The path of the file.

        Raises:
            GaitsimError: too many gaits are given, the body cannot be drawn, or the file cannot be
                written.
        """
        path, run = Path(path), self.snapshot
        individuals = tuple(run.individual(one) for one in generations or (None,))
        _page_exporter().write(Subject(run, individuals), path)
        return path
