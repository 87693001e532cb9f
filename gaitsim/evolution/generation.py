"""What the loop yields: one finished generation, frozen."""

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
    """The state of a search apart from its population.

    Attributes:
        evaluations: number of individuals evaluated.
        best_score: the best score so far, −inf where none was finite.
        stagnation: generations since the best score last rose.
        threshold: score that the next champion must beat; None where none is kept.
        stage: number of the stage, from 1; changing the experiment of a run begins the next.
    """

    evaluations: int
    best_score: float
    stagnation: int
    threshold: float | None
    stage: int = 1

    def next_stage(self, evolution: Evolution, *, reevaluated: bool, population: int) -> "Progress":
        """Return the progress with which the next stage begins.

        New scores cannot be compared with those of the stage before. Re-evaluating the population
        counts.

        Args:
            evolution: of the next stage.
            reevaluated: whether body, fitness or worlds were changed.
            population: individuals.
        """
        if not reevaluated:
            return replace(self, stage=self.stage + 1)
        progress = self.with_other_scores(evolution, population)
        return replace(progress, stage=self.stage + 1)

    def with_other_scores(self, evolution: Evolution, evaluated: int) -> "Progress":
        """Return the progress before a generation whose scores compare with none before it.

        Best score and threshold start as in a run's first generation.

        Args:
            evolution: of the generation.
            evaluated: individuals that were re-evaluated.
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
        number: from 1.
        genomes: (population, genes).
        evaluation: its scores, their terms, and reasons of failures.
        progress: of the search, this generation included.
        diversity: of the genomes, by their space's measure.
        seconds: time that asking for it and evaluating it took.
        is_champion: whether its best individual beat the threshold.
        stop: why the search ends here, '' where it continues.
        state: of the search, after this generation's scores.
        figures: what the search says of itself, by name.
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
        """(population,), more is better."""
        return self.evaluation.scores

    @property
    def best(self) -> int:
        """Index of the best individual; the first of equals."""
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
