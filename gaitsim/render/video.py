"""Videos of a run: its fitness curve, followed by its moving champions."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.gait.channels import count_trials
from gaitsim.individual import Choice, Individual
from gaitsim.render.film import Film, RenderSettings
from gaitsim.render.plots.fitness import fitness_figure
from gaitsim.render.plots.labels import format_score, shorten
from gaitsim.render.scene.clip import clip_of
from gaitsim.render.scene.labels import ROW, ROWS, small_letters
from gaitsim.storage.snapshot import RunSnapshot

LONGEST = 60  # characters of a note


class Video(Film):
    """A video of a champion of a run, or of a race of several.

    Args:
        run: the run.
        generations: generations whose best individuals to show, or members; () for the champion.
        settings: size, speed, view and colours; None for the defaults of `RenderSettings`.
        changed: function that changes the body or the world of an individual, such as
            `with_world`.
    """

    def __init__(
        self,
        run: RunSnapshot,
        generations: Sequence[Choice] | Choice = (),
        settings: RenderSettings | None = None,
        changed: Callable[[Individual], Individual] = lambda individual: individual,
    ) -> None:
        settings = settings or RenderSettings()
        if run.generation == 1:
            settings = replace(settings, intro=False)  # one point makes no curve
        shown = [*map(changed, run.individuals(generations))]
        self.generations = tuple(one.generation for one in shown)
        self._stem = shown[0].stem
        _check_room(len(shown), settings.pixels)
        if len(shown) > 1:
            clips = [clip_of(one, *_words(one), tag=str(one.generation)) for one in shown]
        else:
            clips = [clip_of(shown[0])]
        super().__init__(
            clips,
            settings,
            (shown[0].name, _details(shown)),
            partial(fitness_figure, run),
            leader=int(np.argmax([one.score for one in shown])),
        )

    @property
    def name(self) -> str:
        """The default name of the file."""
        numbers = "-".join(map(str, self.generations))
        if len(self.generations) == 1:
            return f"video-{self._stem}.{self.settings.format}"
        many = f"{self.generations[0]}-to-{self.generations[-1]}" if len(numbers) > 60 else numbers
        return f"video-generations-{many}.{self.settings.format}"


def _details(shown: Sequence[Individual]) -> list[str]:
    """Return the parts of the second line of text."""
    one = shown[0]
    details = ["   ".join(_words(one)) if len(shown) == 1 else _group(shown)]
    if (trials := count_trials(one)) > 1:
        details.append(f"first of {trials} trials")
    return details


def _group(shown: Sequence[Individual]) -> str:
    """Return what several individuals are."""
    bests = all(one.best_of for one in shown)
    return "the best of each generation" if bests else "individuals of several generations"


def _check_room(bodies: int, size: tuple[int, int]) -> None:
    most = int(ROWS * size[1] / (ROW * small_letters(size)))
    if bodies > max(most, 1):
        raise GaitsimError(
            f"{bodies} bodies do not fit into {size[0]}x{size[1]} pixels",
            where="--generations",
            allowed=f"at most {most} bodies at this size",
            remedy="choose fewer generations, or a larger picture with --size",
        )


def _words(shown: Individual) -> tuple[str, str]:
    note = f": {shorten(shown.note, LONGEST)}" if shown.note else ""
    return f"{shown.label}{note}", format_score(shown)
