"""Imitate a gait: train a network, let it play on its own, and evaluate what it plays."""

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.choices import GaitFormat, TrainingPreset
from gaitsim.errors import GaitsimError, unknown
from gaitsim.evaluation.playing import play
from gaitsim.gait.files.writer import gait_of
from gaitsim.imitation.expert import Expert, expert_of, find_expert
from gaitsim.imitation.file import Imitation
from gaitsim.imitation.imitator import Angles
from gaitsim.imitation.learning import SETTINGS, Settings, learn
from gaitsim.individual import Individual, Member
from gaitsim.render.notebook import RunViews
from gaitsim.repr_mixin import ReprField, ReprMixin

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gaitsim.imitation.results import Files

TOLERANCE = 1e-6  # rad: smaller differences are rounding, not limits
_FORWARD = "forward"  # the measure of the way that a body walks


@dataclass(frozen=True, eq=False, repr=False)
class Result(ReprMixin):
    """A trained imitator and how it performs.

    Attributes:
        settings: of the training.
        expert: the gait that the network imitates.
        imitation: the network and the gait that it plays.
        errors: mean squared error of the next frame after each epoch, (epochs,), rad².
        one_step: the same after the last epoch.
        free_running: mean squared difference from the expert's gait when it plays on its own.
        played: the imitation on the expert's body, scored; None where the body cannot play
            joint angles.
        beyond_limits: number of commanded angles that the body limited; None there, too.
    """

    settings: Settings
    expert: Expert
    imitation: Imitation
    errors: NDArray[np.float64]
    one_step: float
    free_running: float
    played: Individual | None
    beyond_limits: int | None

    @property
    def expert_beyond_limits(self) -> int:
        """The number of angles in a gait file that the body limits; 0 where it does not play it."""
        if self.expert.individual is None or self.expert.file is None:
            return 0
        return _differing(gait_of(self.expert.individual).angles, self.expert.gait.angles)

    @property
    def sizes(self) -> str:
        """The number of neurons in each layer, such as '24-48-24'."""
        return "-".join(map(str, self.imitation.imitator.network.sizes))

    @property
    def heading(self) -> str:
        """Whose imitator it is, and its activation, for figures."""
        return f"imitator of {self.expert.heading}, {self.settings.activation}"

    @property
    def forward_kept(self) -> float | None:
        """The share of the expert's way forward, where the body measures it and it is positive."""
        if self.played is None or self.expert.individual is None:
            return None
        whole = self.expert.individual.measures.get(_FORWARD)
        reached = self.played.measures.get(_FORWARD)
        if whole is None or whole <= 0 or reached is None:
            return None
        return reached / whole

    def save(self, folder: str | Path, format: GaitFormat = "mat") -> "Files":
        """Write the network, its gait and a plot of its error, as `gaitsim imitate` does.

        Args:
            folder: created if missing.
            format: of the gait file, 'mat', 'npz' or 'csv'.

        Returns:
            The files, by what they hold.

        Raises:
            GaitsimError: there is no such format, or a file would replace the gait file that the
                network imitates.
            RunError: a file cannot be written.
        """
        from gaitsim.imitation.results import files_of, write_results
        from gaitsim.runs.files.folder import create_out_folder

        if format not in get_args(GaitFormat):
            raise unknown("format", format, get_args(GaitFormat))
        files = files_of(Path(folder), format, gait=self.expert.file)
        create_out_folder(Path(folder))
        write_results([self], files)
        return files

    def video(
        self,
        path: str | Path,
        *,
        view: str = "iso",
        size: tuple[int, int] | None = None,
        fps: float | None = None,
        speed: float | None = None,
        dark: bool = False,
        intro: bool = True,
    ) -> Path:
        """Write a video of the imitator beside its expert, as `gaitsim imitate --video` does.

        Args:
            path: the file, MP4 or GIF by its ending.
            view: 'iso', 'side', 'top' or 'orbit'.
            size: width and height, pixels.
            fps: pictures a second.
            speed: of the motion; 0.1 is slow motion.
            dark: on a dark ground.
            intro: whether it begins with the error over the training.

        Returns:
            The file.

        Raises:
            GaitsimError: the body cannot play joint angles, or the video cannot be made so or
                not be written.
        """
        from gaitsim.imitation.film import imitation_film
        from gaitsim.render.settings import RenderSettings

        path, theme = Path(path), "dark" if dark else "light"
        settings = RenderSettings(path.suffix[1:].lower(), size, fps, speed, view, theme, intro)
        film = imitation_film(self, settings)
        if film.caution:
            warnings.warn(film.caution, stacklevel=2)
        film.write(path)
        return path

    def plot(self, *, dark: bool = False) -> "Figure":
        """Return a figure of the error over the training."""
        from gaitsim.render.notebook import shown_in_notebooks
        from gaitsim.render.plots.imitation import errors_figure
        from gaitsim.render.plots.style import DARK, LIGHT

        theme = DARK if dark else LIGHT
        figure = errors_figure({self.settings.activation: self.errors}, self.heading, theme)
        return shown_in_notebooks(figure, theme)

    def _repr_fields(self) -> Mapping[str, ReprField]:
        kept = self.forward_kept
        return {
            "expert": self.expert.title,
            "network": f"{self.sizes}, {self.settings.activation}",
            "one_step": self.one_step,
            "free_running": self.free_running,
            "score": "" if self.played is None else self.played.score,
            "forward_kept": "" if kept is None else kept,
        }


def imitate_expert(
    expert: Expert, settings: Settings, progress: Callable[[int], object] = lambda epochs: None
) -> Result:
    """Train a network, let it play as many frames on its own, and evaluate it.

    Args:
        expert: the gait.
        settings: of the training.
        progress: called with the number of epochs since the last call.

    Raises:
        GaitsimError: the training diverged.
        PluginError: the body or the fitness breaks its contract.
    """
    gait, experiment = expert.gait, expert.experiment
    imitator, errors = learn(gait.angles, settings, progress)
    commanded = imitator.free_run(gait.angles[0], len(gait.angles))
    performed, played, beyond = replace(gait, angles=commanded, score=math.nan), None, None
    if experiment.organism.can_play:
        motion = play(experiment, commanded[None])
        played = Individual.of_motion(experiment, motion, expert.source)
        performed = replace(gait, angles=gait_of(played).angles, score=played.score)
        beyond = _differing(performed.angles, commanded)
    return Result(
        settings=settings,
        expert=expert,
        imitation=Imitation(performed, commanded, imitator, settings.seed),
        errors=errors,
        one_step=imitator.one_step_error(gait.angles),
        free_running=float(np.mean((commanded - gait.angles) ** 2)),
        played=played,
        beyond_limits=beyond,
    )


def _differing(played: Angles, commanded: Angles) -> int:
    return int(np.count_nonzero(np.abs(played - commanded) > TOLERANCE))


def imitate(
    source: str | Path | RunViews | Individual,
    settings: TrainingPreset | Settings = "source",
    *,
    body: str | Path | None = None,
    generation: int | None = None,
    member: int | None = None,
    **changes: Any,
) -> Result:
    """Train a network that imitates a champion or a gait file, as `gaitsim imitate` does.

    Args:
        source: a run, its name or folder; a gait file, `.mat`, `.npz` or `.csv`; an individual.
        settings: 'source', 'steady' or an object of `Settings`.
        body: of a gait file: a preset's name, the path of an experiment or of a robot's file, or
            a run's folder. None finds it as the command does.
        generation: of a run, whose best; None for the best of all.
        member: of a run, a member of its front or archive instead, from 1.
        **changes: of the settings, such as `epochs=3000` or `seed=1`.

    Raises:
        GaitsimError: there is no such run, file, individual or setting, or the gait cannot be
            learnt.
        PluginError: the body or the fitness breaks its contract.
    """
    if isinstance(settings, str):
        if settings not in SETTINGS:
            raise unknown("settings", settings, SETTINGS)
        settings = SETTINGS[settings]
    known = [field.name for field in fields(Settings)]
    for name in changes:
        if name not in known:
            raise unknown("setting of imitate()", name, known)
    if generation is not None and member is not None:
        raise GaitsimError("imitate() takes a generation or a member, not both", where="arguments")
    which = generation if member is None else Member(member)
    if isinstance(source, Individual):
        if body is not None or which is not None:
            raise GaitsimError(
                "an individual has a body of its own, and is one of its run",
                where="arguments",
                remedy="leave body, generation and member out",
            )
        expert = expert_of(source)
    else:
        path = source.path if isinstance(source, RunViews) else source
        expert = find_expert(str(path), None if body is None else str(body), which)
    return imitate_expert(expert, replace(settings, **changes))
