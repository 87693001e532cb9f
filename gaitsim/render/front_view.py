"""Views of a front: its members, the directions of the objectives, and the other individuals."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Members, Results
from gaitsim.evolution.transferability import RealityTests, with_predictions
from gaitsim.storage.snapshot import RunSnapshot

Direction = Literal["max", "min"]


@dataclass(frozen=True, eq=False)
class FrontView:
    """A Pareto front.

    Attributes:
        members: its members.
        directions: 'max' or 'min' for each objective by name.
        others: values of the objectives of the individuals of the last generation by name, each
            (population,); NaN for failed individuals.
    """

    members: Members
    directions: Mapping[str, Direction]
    others: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    @classmethod
    def of(cls, run: RunSnapshot) -> "FrontView | None":
        """Return the view of a run's front; None if its search keeps none."""
        members = run.members
        if members is None or members.cells is not None or len(members.values) < 2:
            return None
        last = run.finished
        results = Results(last.genomes, last.scores, last.values)
        if (tests := RealityTests.of(last.state)) is not None:
            results = with_predictions(run.experiment_at(run.generation), tests, results)
        values = {**results.values, "score": results.scores}
        others = {name: values[name] for name in members.values if name in values}
        given = cast(Mapping[str, Direction], getattr(run.experiment.search, "objectives", {}))
        return cls(members, {name: given.get(name, "max") for name in members.values}, others)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the objectives."""
        return tuple(self.members.values)

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """The pairs of objectives."""
        return tuple(combinations(self.names, 2))

    @property
    def best(self) -> int | None:
        """Number of the member with the highest score; None for an empty front."""
        scores = self.members.scores
        return int(np.argmax(scores)) + 1 if len(scores) else None
