"""Imitate a gait: train a network, let it play without the expert, and evaluate the result."""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitFormat, GaitsimError, ReprField, ReprMixin, TrainingPreset, unknown
from gaitsim.plugin.gait import gait_of, write_gait
from gaitsim.plugin.pictures import Clip, Film, RenderSettings, clip_of, format_score
from gaitsim.plugin.runs import Individual, Member, play, require_play
from gaitsim_imitation.expert import Expert, expert_of, find_expert
from gaitsim_imitation.imitator import Angles, Imitation, save_imitator
from gaitsim_imitation.learning import SETTINGS, TrainingSettings, learn
from gaitsim_imitation.plots import errors_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TOLERANCE = 1e-6  # rad: smaller differences are rounding, not limits
_FORWARD = "forward"  # the measure of the distance that a body walks


@dataclass(frozen=True, eq=False, repr=False)
class Result(ReprMixin):
    """A trained imitator and its performance.

    Attributes:
        settings: settings of the training.
        expert: gait that the network imitates.
        imitation: network and the gait that it plays.
        errors: mean squared error of the next frame after each epoch, (epochs,), rad².
        one_step: mean squared error of the next frame after the last epoch, rad².
        free_running: mean squared difference from the expert's gait when the network plays without
            the expert, rad².
        played: imitation on the expert's body, with its score; None if the body cannot play joint
            angles.
        beyond_limits: number of commanded angles that the body limited; None if the body cannot
            play joint angles.
    """

    settings: TrainingSettings
    expert: Expert
    imitation: Imitation
    errors: NDArray[np.float64]
    one_step: float
    free_running: float
    played: Individual | None
    beyond_limits: int | None

    @property
    def expert_beyond_limits(self) -> int:
        """Number of angles in a gait file that the body limits; 0 if it cannot play the file."""
        if self.expert.individual is None or self.expert.file is None:
            return 0
        return _differing(gait_of(self.expert.individual).angles, self.expert.gait.angles)

    @property
    def sizes(self) -> str:
        """Numbers of neurons in the layers, such as '24-48-24'."""
        return "-".join(map(str, self.imitation.imitator.network.sizes))

    @property
    def heading(self) -> str:
        """Heading for figures, with the name of the expert and the activation."""
        return f"imitator of {self.expert.heading}, {self.settings.activation}"

    @property
    def forward_kept(self) -> float | None:
        """Share of the expert's forward distance that the imitator walks.

        It is None if the body cannot play joint angles or does not measure the distance, or if the
        expert does not walk forward.
        """
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
            folder: folder to write to, created if missing.
            format: format of the gait file, 'mat', 'npz' or 'csv'.

        Returns:
            The files, by their content.

        Raises:
            GaitsimError: the format is unknown, or a file would replace the imitated gait file.
            RunError: a file cannot be written.
        """
        from gaitsim.plugin.runs import create_out_folder

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
            path: file to write, an MP4 or GIF according to its suffix.
            view: view of the body, 'iso', 'side', 'top' or 'orbit'.
            size: width and height, pixels.
            fps: frames per second.
            speed: speed of the motion; 0.1 is slow motion.
            dark: whether to use a dark background.
            intro: whether to begin with the error during training.

        Returns:
            The file.

        Raises:
            GaitsimError: the body cannot play joint angles, a setting is invalid, or the file
                cannot be written.
        """
        from gaitsim.plugin.pictures import RenderSettings

        path, theme = Path(path), "dark" if dark else "light"
        settings = RenderSettings(path.suffix[1:].lower(), size, fps, speed, view, theme, intro)
        film = imitation_film(self, settings)
        if film.warning:
            warnings.warn(film.warning, stacklevel=2)
        film.write(path)
        return path

    def plot(self, *, dark: bool = False) -> "Figure":
        """Return a figure of the error during training."""
        from gaitsim.plugin.pictures import DARK, LIGHT, enable_notebook_display
        from gaitsim_imitation.plots import errors_figure

        theme = DARK if dark else LIGHT
        figure = errors_figure({self.settings.activation: self.errors}, self.heading, theme)
        return enable_notebook_display(figure, theme)

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
    expert: Expert,
    settings: TrainingSettings,
    progress: Callable[[int], object] = lambda epochs: None,
) -> Result:
    """Train a network, let it play the gait's length without the expert, and evaluate it.

    Args:
        expert: gait to learn.
        settings: settings of the training.
        progress: called with the number of epochs since the last call.
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
        free_running=float(np.mean(np.square(commanded - gait.angles))),
        played=played,
        beyond_limits=beyond,
    )


def _differing(played: Angles, commanded: Angles) -> int:
    return int(np.count_nonzero(np.abs(played - commanded) > TOLERANCE))


def imitate(
    source: Any,
    settings: TrainingPreset | TrainingSettings = "source",
    *,
    body: str | Path | None = None,
    generation: int | None = None,
    member: int | None = None,
    **changes: Any,
) -> Result:
    """Train a network that imitates a champion or a gait file, as `gaitsim imitate` does.

    Args:
        source: a run, or its name or folder; a gait file, `.mat`, `.npz` or `.csv`; or an
            individual.
        settings: 'source', 'steady' or a `TrainingSettings` object.
        body: body of a gait file: the name of a preset, or the path of an experiment, a robot's
            file or a run's folder. None finds the body as `gaitsim imitate` does.
        generation: generation of a run whose best individual is imitated; None for the best of
            all generations.
        member: number of a member of the run's front or archive, counted from 1, to imitate
            instead.
        **changes: changes of the settings, such as `epochs=3000` or `seed=1`.

    Raises:
        GaitsimError: there is no such run, file, individual or setting, or the gait cannot be
            learnt.
        PluginError: the body or the fitness breaks its contract.
    """
    if isinstance(settings, str):
        if settings not in SETTINGS:
            raise unknown("settings", settings, SETTINGS)
        settings = SETTINGS[settings]
    known = [field.name for field in fields(TrainingSettings)]
    for name in changes:
        if name not in known:
            raise unknown("setting of imitate()", name, known)
    if generation is not None and member is not None:
        raise GaitsimError("'generation' and 'member' cannot be combined", where="arguments")
    which = generation if member is None else Member(member)
    if isinstance(source, Individual):
        if body is not None or which is not None:
            raise GaitsimError(
                "an individual already determines 'body', 'generation' and 'member'",
                where="arguments",
                remedy="omit 'body', 'generation' and 'member'",
            )
        expert = expert_of(source)
    else:
        path = source if isinstance(source, str | Path) else source.path
        expert = find_expert(str(path), None if body is None else str(body), which)
    return imitate_expert(expert, replace(settings, **changes))


def imitation_film(result: Result, settings: RenderSettings | None = None) -> Film:
    """Return a video that shows the training error, then the imitator beside its expert.

    Args:
        result: result of the training.
        settings: size, speed, view and colours; None for the defaults of `RenderSettings`.
    """
    expert, training = result.expert, result.settings
    require_play(expert.experiment)
    assert expert.individual is not None, "a body that plays the imitator plays its expert"
    assert result.played is not None, "require_play checks that the body can play"
    generation = "" if expert.file else f", {expert.individual.label}"
    clips = [_clip(expert.individual, "expert", generation), _clip(result.played, "imitator")]
    errors = {training.activation: result.errors}
    return Film(
        clips,
        settings or RenderSettings(),
        (f"imitator of {expert.name}", (f"network {result.sizes}, {training.activation}",)),
        partial(errors_figure, errors, result.heading),
        leader=1,
    )


def _clip(individual: Individual, role: str, which: str = "") -> Clip:
    return clip_of(individual, role + which, format_score(individual), tag=role)


Files = Mapping[str, Path]


def files_of(
    folder: Path, format: str, *, several: bool = False, video: bool = False, gait: Path | None
) -> Files:
    """Return the files to write, by their content.

    Args:
        folder: folder to write to.
        format: format of the imitator's gait file.
        several: whether to plot the errors of several trainings.
        video: whether to include a video.
        gait: imitated gait file, which must not be replaced.
    """
    files = {
        "imitator": folder / "imitator.npz",
        "gait": folder / f"imitator-gait.{format}",
        "error": folder / "imitator-error.png",
    }
    if several:
        files["activations"] = folder / "imitator-activations.png"
    if video:
        files["video"] = folder / "imitator.mp4"
    if gait is not None and any(path.absolute() == gait.absolute() for path in files.values()):
        raise GaitsimError(
            f"the imitator's files would replace the imitated gait file {gait}",
            remedy="choose a different folder: --out FOLDER",
        )
    return files


def write_results(results: Sequence[Result], files: Files) -> None:
    """Write the first result, and a plot of the errors of all results if `files` includes one."""
    from gaitsim.plugin.pictures import save
    from gaitsim_imitation.plots import errors_figure

    first = results[0]
    save_imitator(first.imitation, files["imitator"])
    write_gait(first.imitation.gait, files["gait"], files["gait"].suffix[1:])
    errors = {result.settings.activation: result.errors for result in results}
    one = {first.settings.activation: first.errors}
    save(errors_figure(one, first.heading), files["error"])
    if "activations" in files:
        save(errors_figure(errors, f"imitator of {first.expert.heading}"), files["activations"])


def to_dict(results: Sequence[Result], files: Files) -> dict[str, Any]:
    """Return the first result, and with several activations the results of all, for JSON."""
    expert = results[0].expert
    found = {
        "run": None if expert.file else str(expert.source),
        "gait": str(expert.file) if expert.file else None,
        "body": expert.body or None,
        "generation": expert.gait.generation or None,
        "expert": _performance(expert.individual),
        "expert_beyond_limits": results[0].expert_beyond_limits,
        **_result(results[0]),
        "files": {what: str(path) for what, path in files.items()},
    }
    if len(results) > 1:
        found["activations"] = [_result(result) for result in results]
    return found


def _result(result: Result) -> dict[str, Any]:
    return {
        "settings": asdict(result.settings),
        "one_step_mse": result.one_step,
        "free_running_mse": result.free_running,
        "beyond_limits": result.beyond_limits,
        "angles": result.imitation.commanded.size,
        "imitator": _performance(result.played),
        "forward_kept": result.forward_kept,
    }


def _performance(individual: Individual | None) -> dict[str, object] | None:
    if individual is None:
        return None
    return {
        "score": individual.score,
        "terms": dict(individual.terms),
        "measures": individual.measures,
    }
