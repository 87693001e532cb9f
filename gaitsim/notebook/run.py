"""A run on disk, as Python and notebooks look at it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Motion
from gaitsim.errors import unknown
from gaitsim.experiment import Experiment
from gaitsim.individual import Individual
from gaitsim.notebook.search import ARGUMENTS, Search, overrides, resumed
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.runs.files.folder import find_run
from gaitsim.runs.snapshot import RunSnapshot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCREEN = 150  # dots an inch of a figure in a notebook


def load(run: str | Path) -> "Run":
    """Open a run for reading, by its folder or its name under `runs/`.

    Opening a run never executes anything in it.

    Raises:
        RunError: there is none.
    """
    return Run(find_run(str(run)))


class Run(ReprMixin):
    """A run on disk. What it says is read anew each time: it may be growing.

    Attributes:
        path: its folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def snapshot(self) -> RunSnapshot:
        """The run as it is now; each of its files is read at most once."""
        return RunSnapshot(self.path)

    @property
    def experiment(self) -> Experiment:
        """As it stands in the run's `experiment.toml`.

        Raises:
            ExperimentError: it has problems, such as a plugin that is no longer installed.
        """
        return self.snapshot.experiment

    @property
    def history(self) -> dict[str, NDArray[np.float64]]:
        """The columns of `history.csv` by name, (generations,) each; {} before the first one.

        Raises:
            RunError: it is damaged.
        """
        return self.snapshot.history

    @property
    def generation(self) -> int:
        """The last one that is finished; 0 before the first."""
        return self.snapshot.generation

    @property
    def champion(self) -> Individual:
        """The best individual of all generations whose scores can be compared.

        Raises:
            RunError: no generation is finished yet, or all individuals failed.
        """
        return self.replay()

    @property
    def motion(self) -> Motion:
        """The champion's motion, a population of one."""
        return self.champion.motion

    def replay(self, generation: int | None = None) -> Individual:
        """The best individual of one generation; of all where none is given.

        Raises:
            RunError: there is no such generation, or all its individuals failed.
        """
        return self.snapshot.individual(generation)

    def fingerprint(self) -> str:
        """SHA-256 of population, scores and history, times left out.

        Raises:
            RunError: no generation is finished yet.
        """
        return self.snapshot.fingerprint()

    def resume(
        self,
        generations: int | None = None,
        *,
        set: Mapping[str, Any] | None = None,
        workers: int | None = None,
    ) -> Search:
        """Go on with the run, exactly as if it had never stopped; a search to loop over.

        Args:
            generations: how far it is to go, counted from the first one; None as planned.
            set: options from here on, by key; those that matter begin a stage.
            workers: how many work at a time; None for what suits the body.

        Raises:
            ExperimentError: the options have problems. What else is wrong with going on is
                raised when the loop begins.
        """
        given = overrides({}, set)
        further = overrides({"evolution.generations": generations}, None)
        experiment = self.snapshot.experiment_with({**further, **given}, ARGUMENTS)
        return resumed(self.path, experiment, workers, given, generations)

    def plot(
        self,
        kind: str = "fitness",
        *,
        generations: Sequence[int] = (),
        channel: str | None = None,
        components: Sequence[str] = (),
        window: tuple[float, float] | None = None,
        dark: bool = False,
    ) -> "Figure":
        """A plot, as `gaitsim plot` makes it.

        Args:
            kind: 'fitness', 'terms', 'path', 'channel', 'footfall', 'joints', 'stability'.
            generations: whose best to draw; () for the champion.
            channel: of the motion, for the kind 'channel'.
            components: names of what to draw of the channel; () draws all.
            window: first and last second of the motion.
            dark: light lines on a dark ground.

        Returns:
            The figure; a notebook shows it, `savefig` writes it.

        Raises:
            GaitsimError: there is no such kind, or the body has nothing of it.
        """
        from gaitsim.render.plots import DARK, LIGHT, picture
        from gaitsim.render.plots.kinds import KINDS, draw
        from gaitsim.render.plots.request import Request

        if kind not in KINDS:
            raise unknown("kind of plot", kind, KINDS)
        theme = DARK if dark else LIGHT
        individuals: tuple[Individual, ...] = ()
        if KINDS[kind].moves:
            individuals = tuple(self.snapshot.individual(one) for one in generations or (None,))
        shown = tuple(components)
        figure = draw(kind, Request(self.snapshot, individuals, channel, shown, window, theme))
        # Notebooks know figures of pyplot alone, which keeps every figure until it is closed.
        figure._repr_png_ = lambda: picture(figure, "png", theme, SCREEN)  # type: ignore[attr-defined]
        return figure

    def video(
        self,
        path: str | Path,
        *,
        generations: Sequence[int] = (),
        view: str = "iso",
        size: tuple[int, int] | None = None,
        fps: float | None = None,
        speed: float = 1.0,
        dark: bool = False,
        intro: bool = True,
    ) -> Path:
        """Write a video, as `gaitsim video` does; MP4 or GIF, as the file's name ends.

        Args:
            path: the file.
            generations: whose best to show side by side; () for the champion.
            view: 'iso', 'side', 'top' or 'orbit'.
            size: width and height, pixels.
            fps: pictures a second.
            speed: of the motion; 0.1 is slow motion.
            dark: on a dark ground.
            intro: whether it begins with the fitness curve.

        Returns:
            The file.

        Raises:
            GaitsimError: it cannot be made so, or not be written.
        """
        from gaitsim.render.video import RenderSettings, Video

        path = Path(path)
        theme = "dark" if dark else "light"
        settings = RenderSettings(path.suffix[1:].lower(), size, fps, speed, view, theme, intro)
        Video(self.snapshot, generations, settings).write(path)
        return path

    def _repr_fields(self) -> Mapping[str, ReprField]:
        found = self.snapshot.checkpoint
        best = found.best_score if found else -np.inf
        return {
            "path": str(self.path),
            "generation": found.generation if found else 0,
            "best": best if np.isfinite(best) else "",
        }

    def _repr_details(self) -> Mapping[str, ReprField]:
        return {**self._repr_fields(), **self.experiment._repr_fields()}
