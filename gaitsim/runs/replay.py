"""A kept individual, moved again: what plots, videos, analyses and exports start from."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from numpy.typing import NDArray

from gaitsim.contracts import Motion, Skeleton
from gaitsim.errors import PluginError
from gaitsim.experiment import Experiment
from gaitsim.registry import plugin_errors
from gaitsim.runs.reader import Run


@dataclass(frozen=True, eq=False)
class Replay:
    """One generation's best, and how it moves.

    Attributes:
        run: where it was found.
        experiment: as it was in its generation.
        generation: in which it was found.
        score: its score then.
        genome: (genes,).
    """

    run: Run
    experiment: Experiment
    generation: int
    score: float
    genome: NDArray[Any]

    @cached_property
    def motion(self) -> Motion:
        """Its motion: a population of one.

        Raises:
            PluginError: the body cannot move it.
        """
        return motion_of(self.experiment, self.genome)

    @cached_property
    def skeleton(self) -> Skeleton:
        """Its skeleton over time.

        Raises:
            PluginError: the body cannot be drawn.
        """
        return skeleton_of(self.experiment, self.motion)


def motion_of(experiment: Experiment, genome: NDArray[Any]) -> Motion:
    """The motion of one genome, (genes,), by the experiment's body: a population of one.

    Raises:
        PluginError: the body cannot move it.
    """
    with plugin_errors(experiment.entries["organism"], "moving the champion"):
        return experiment.organism.move(genome[None].copy())


def skeleton_of(experiment: Experiment, motion: Motion) -> Skeleton:
    """The skeleton over time of the first individual of a motion of the experiment's body.

    Raises:
        PluginError: the body cannot be drawn.
    """
    entry = experiment.entries["organism"]
    with plugin_errors(entry, "drawing the champion"):
        skeleton: object = experiment.organism.skeleton(motion, 0)
    if isinstance(skeleton, Skeleton):
        return skeleton
    raise PluginError(
        f"{entry} gave a {type(skeleton).__name__} from skeleton()",
        where=entry.target,
        allowed="a gaitsim.contracts.Skeleton",
        remedy=f"update {entry.package}, or report it to its author",
    )


def replay(run: Run, generation: int | None = None) -> Replay:
    """The best individual of a run, or of one generation.

    Raises:
        RunError: there is no such generation, or no champion.
    """
    number, score, genome = run.champion(generation)
    return Replay(run, run.experiment_at(number), number, score, genome)
