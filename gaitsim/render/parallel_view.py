"""Parallel coordinates: an axis for each quantity, and a line across them for each item.

Inselberg 1985, "The plane with parallel coordinates". The items are, for example, the members of a
front or an archive.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Members
from gaitsim.errors import unknown
from gaitsim.evaluation.scoring import move_genomes
from gaitsim.experiment import Experiment
from gaitsim.individual import Member
from gaitsim.registry import plugin_errors
from gaitsim.render.ticks import clipped, ends_of, labels, ticks
from gaitsim.storage.snapshot import RunSnapshot

SPREAD = 0.5  # distance between the outermost items with the same choice, in choices
_CHUNK = 100  # members that are simulated at once
SCORE = "score"

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ParallelAxis:
    """One axis.

    Attributes:
        name: name of the quantity.
        values: value of each item, (items,); NaN if unknown.
        unit: unit of the values, or ''.
        better: 'max' or 'min' if more or less is better, else ''.
        choices: words of the values 0, 1, 2 …; () for an axis of numbers.
    """

    name: str
    values: Floats
    unit: str = ""
    better: Literal["max", "min", ""] = ""
    choices: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The name with the unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    @cached_property
    def ends(self) -> tuple[float, float]:
        """The values at both ends of the axis, which differ."""
        if self.choices:
            return -0.5, len(self.choices) - 0.5
        return ends_of(self.values)

    def share(self, values: Floats) -> Floats:
        """Return the position of values along the axis, 0 to 1; NaN for values that are not."""
        low, high = self.ends
        shares: Floats = (clipped(values) - low) / (high - low)
        return shares

    def ticks(self, most: int) -> list[tuple[float, str]]:
        """Return at most about `most` positions along the axis with the words or numbers there."""
        if self.choices:
            step = -(-len(self.choices) // max(most, 1))
            at = np.arange(0, len(self.choices), step)
            words = [self.choices[index] for index in at.tolist()]
            return list(zip(self.share(at.astype(float)).tolist(), words, strict=True))
        values = ticks(*self.ends, most)
        return list(zip(self.share(values).tolist(), labels(values), strict=True))


@dataclass(frozen=True, eq=False)
class ParallelView:
    """Items along parallel axes.

    Attributes:
        axes: the axes; the last one is the score.
        items: plural of the noun for a line, such as 'members'.
    """

    axes: tuple[ParallelAxis, ...]
    items: str

    @property
    def scores(self) -> Floats:
        """The score of each item, (items,); NaN if it has none."""
        return self.axes[-1].values

    @cached_property
    def shares(self) -> Floats:
        """The position of each item along each axis, (items, axes); NaN if unknown.

        Items with the same choice are side by side, ordered by score.
        """
        rank = np.argsort(np.argsort(np.nan_to_num(self.scores, nan=-np.inf), kind="stable"))
        beside = SPREAD * (rank / max(len(rank) - 1, 1) - 0.5)
        return np.stack(
            [axis.share(axis.values + (beside if axis.choices else 0)) for axis in self.axes],
            axis=1,
        )

    @property
    def best(self) -> int | None:
        """Index of the item with the highest score; None if no item has a score."""
        known = np.isfinite(self.scores)
        return int(np.argmax(np.where(known, self.scores, -np.inf))) if known.any() else None

    @classmethod
    def of_run(cls, run: RunSnapshot, measures: Sequence[str] = ()) -> "ParallelView":
        """Return the members of a run's front or archive.

        Args:
            run: the run.
            measures: measures of the body for more axes; they are simulated.

        Raises:
            GaitsimError: the run has no members, or a measure is unknown.
        """
        members = run.required_members("evolve with a search such as 'nsga-2' or 'map-elites'")
        directions: Mapping[str, Literal["max", "min"]] = {}
        if members.cells is None:
            directions = getattr(run.experiment.search, "objectives", {})
        unit_of = run.individual(Member(1)).unit_of if len(members.scores) else lambda name: ""
        axes = [
            ParallelAxis(name, values, unit_of(name), directions.get(name, ""))
            for name, values in members.values.items()
            if name != SCORE
        ]
        experiment = run.experiment_at(run.generation)
        axes += _measured(experiment, members, [one for one in measures if one != SCORE])
        axes.append(ParallelAxis(SCORE, members.scores, unit_of(SCORE), "max"))
        return cls(tuple(axes), "members")


def _measured(
    experiment: Experiment, members: Members, names: Sequence[str]
) -> Iterator[ParallelAxis]:
    """Simulate the members and yield the axes of their measures."""
    if not names or not len(members.scores):
        return
    found: dict[str, list[Floats]] = {name: [] for name in names}
    units: dict[str, str] = {}
    for start in range(0, len(members.scores), _CHUNK):
        motion = move_genomes(experiment, members.genomes[start : start + _CHUNK])
        with plugin_errors(experiment.entries["organism"], "measuring a population"):
            known = experiment.organism.measures(motion)
        for name in names:
            if name not in known:
                raise unknown("measure", name, known)
            found[name].append(np.asarray(known[name].values, np.float64))
            units[name] = known[name].unit
    for name, parts in found.items():
        if name not in members.values:
            yield ParallelAxis(name, np.concatenate(parts), units[name])
