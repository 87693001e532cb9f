"""A finished generation, which the loop yields, and the progress of the search."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, State
from gaitsim.evaluation import Evaluation
from gaitsim.experiment import Evolution
from gaitsim.repr_mixin import ReprField, ReprMixin


@dataclass(frozen=True)
class Progress:
    """The progress of a search, apart from its population and state.

    Attributes:
        evaluations: number of individuals evaluated.
        best_score: best score so far; −inf if none was finite.
        stagnation: number of generations since the best score last increased.
        threshold: score that the next champion must beat; None if champions are not saved.
        stage: number of the stage, counted from 1; changing the experiment of a run starts the
            next stage.
    """

    evaluations: int
    best_score: float
    stagnation: int
    threshold: float | None
    stage: int = 1

    def next_stage(self, evolution: Evolution, *, reevaluated: bool, population: int) -> "Progress":
        """Return the progress at the start of the next stage.

        If the population is re-evaluated, its individuals count as evaluations, and the best score
        is reset, because scores of the two stages cannot be compared.

        Args:
            evolution: size and length of the search in the next stage.
            reevaluated: whether the body, the fitness or the worlds have changed.
            population: number of individuals.
        """
        if not reevaluated:
            return replace(self, stage=self.stage + 1)
        progress = self.reset_scores(evolution, population)
        return replace(progress, stage=self.stage + 1)

    def reset_scores(self, evolution: Evolution, evaluated: int) -> "Progress":
        """Return the progress without the best score, for scores not comparable with earlier ones.

        Best score, stagnation and threshold are as before the first generation of a run.

        Args:
            evolution: size and length of the search.
            evaluated: number of individuals that were re-evaluated.
        """
        return replace(
            self,
            evaluations=self.evaluations + evaluated,
            best_score=-math.inf,
            stagnation=-1,
            threshold=evolution.fitness_threshold,
        )


@dataclass(frozen=True, eq=False, repr=False)
class Generation(ReprMixin):
    """One evaluated generation; its arrays are frozen as well.

    Attributes:
        number: number of the generation, counted from 1.
        genomes: genomes of the population, (population, genes).
        evaluation: scores of the genomes, their terms, and reasons for failures.
        progress: progress of the search, including this generation.
        diversity: diversity of the genomes, as their space defines it.
        seconds: time that `ask` and the evaluation took.
        is_champion: whether the best individual beat the threshold.
        stop: reason why the search ends after this generation; '' if it continues.
        state: state of the search after `tell`.
        figures: numbers about the search by name; see `Search.figures`.
    """

    number: int
    genomes: Genomes
    evaluation: Evaluation
    progress: Progress
    diversity: float
    seconds: float
    is_champion: bool
    stop: str
    state: State = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for values in (self.genomes, self.scores, *self.evaluation.terms.values()):
            values.setflags(write=False)

    @property
    def scores(self) -> NDArray[np.float64]:
        """The scores, (population,); higher is better."""
        return self.evaluation.scores

    @property
    def best(self) -> int:
        """Index of the best individual; ties go to the first."""
        return int(np.argmax(self.scores))

    def _repr_fields(self) -> Mapping[str, ReprField]:
        best, finite = self.best, self.scores[np.isfinite(self.scores)]
        failed = len(self.scores) - len(finite)
        return {
            "number": self.number,
            "best": float(self.scores[best]),
            "mean": float(finite.mean()) if len(finite) else "",
            "diversity": self.diversity,
            "failed": failed or "",
            "terms of the best": self.evaluation.terms_of(best),
            "stop": self.stop,
        }
