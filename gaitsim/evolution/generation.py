"""A finished generation, which the loop yields."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, State
from gaitsim.evaluation import Evaluation
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.stopping import SearchProgress


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
    progress: SearchProgress
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
