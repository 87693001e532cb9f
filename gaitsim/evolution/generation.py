"""What the loop yields: one finished generation, frozen."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes
from gaitsim.evaluation import Evaluation
from gaitsim.repr_mixin import ReprField, ReprMixin


@dataclass(frozen=True)
class Progress:
    """How far a search has come, beside its population.

    Attributes:
        evaluations: individuals evaluated so far.
        best_score: the best score so far, −inf where none was finite.
        stagnation: generations since the best score last rose.
        threshold: score that the next champion must beat, None where none is kept.
        stage: of a run whose experiment was changed on the way, counted from 1.
    """

    evaluations: int
    best_score: float
    stagnation: int
    threshold: float | None
    stage: int = 1


@dataclass(frozen=True, eq=False, repr=False)
class Generation(ReprMixin):
    """One evaluated generation; its arrays are frozen as well.

    Attributes:
        number: from 1.
        genomes: (population, genes).
        evaluation: its scores, their terms, and reasons of failures.
        progress: of the search, this generation counted.
        diversity: of the genomes, by their space's measure.
        seconds: what making and evaluating it took.
        is_champion: whether its best beat the threshold and is to be kept.
        stop: why the search ends here, '' where it goes on.
    """

    number: int
    genomes: Genomes
    evaluation: Evaluation
    progress: Progress
    diversity: float
    seconds: float
    is_champion: bool
    stop: str

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
            "terms of the best": {
                name: float(values[best]) for name, values in self.evaluation.terms.items()
            },
            "stop": self.stop,
        }
