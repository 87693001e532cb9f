"""The progress of a search, and the conditions that end it.

This module imports nothing heavy, as `gaitsim runs` needs it.
"""

import math
from dataclasses import dataclass, replace
from typing import Protocol


class Limits(Protocol):
    """The options of an experiment that limit the length of its search; None sets no limit."""

    @property
    def generations(self) -> int:
        """The number of generations."""

    @property
    def target_score(self) -> float | None:
        """The best score that ends the search."""

    @property
    def max_evaluations(self) -> int | None:
        """The maximum number of evaluations."""

    @property
    def stagnation(self) -> int | None:
        """The number of generations without an improvement that ends the search."""


@dataclass(frozen=True)
class SearchProgress:
    """The progress of a search, apart from its population and state.

    Attributes:
        evaluations: number of individuals evaluated.
        best_score: best score so far; −inf if none was finite.
        stagnation: number of generations since the best score last increased.
        threshold: score that the next champion must beat; None if champions are not saved.
        stage: number of the stage, counted from 1; changing the experiment of a run starts the
            next stage.
        finished: reason why the search itself ends the run, such as convergence; '' if it
            continues.
    """

    evaluations: int
    best_score: float
    stagnation: int
    threshold: float | None
    stage: int = 1
    finished: str = ""

    def next_stage(
        self, threshold: float | None, *, reevaluated: bool, population: int
    ) -> "SearchProgress":
        """Return the progress at the start of the next stage, in which the search may continue.

        If the population is re-evaluated, its individuals count as evaluations, and the best score
        is reset, because scores of the two stages cannot be compared.

        Args:
            threshold: `fitness_threshold` of the next stage.
            reevaluated: whether the body, the fitness or the worlds have changed.
            population: number of individuals.
        """
        progress = self.reset_scores(threshold, population) if reevaluated else self
        return replace(progress, stage=self.stage + 1, finished="")

    def reset_scores(self, threshold: float | None, evaluated: int) -> "SearchProgress":
        """Return the progress without the best score, for scores not comparable with earlier ones.

        Best score, stagnation and threshold are as before the first generation of a run.

        Args:
            threshold: `fitness_threshold` of the experiment.
            evaluated: number of individuals that were re-evaluated.
        """
        return replace(
            self,
            evaluations=self.evaluations + evaluated,
            best_score=-math.inf,
            stagnation=-1,
            threshold=threshold,
        )


def stop_reason(limits: Limits, number: int, progress: SearchProgress, individuals: int) -> str:
    """Return why a search ends after generation `number`; '' if it continues."""
    if number >= limits.generations:
        return f"{number} generations are done"
    target = limits.target_score
    if target is not None and progress.best_score >= target:
        return f"the target score {target:g} is reached"
    if progress.finished:
        return progress.finished
    limit = limits.max_evaluations
    if limit is not None and progress.evaluations + individuals > limit:
        return f"another generation would exceed {limit} evaluations"
    if limits.stagnation is not None and progress.stagnation >= limits.stagnation:
        return f"no better score for {progress.stagnation} generations"
    return ""
