"""The results of a gait in several worlds, and their statistics."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.evaluation.worlds import Ranges, World
from gaitsim.gait.intervals import Floats
from gaitsim.gait.sensitivity import Effect, effects
from gaitsim.repr_mixin import ReprField, ReprMixin

MEASURE, SCORE = "forward", "score"
NEGLIGIBLE = 0.01  # loss below which an effect is omitted, as a share of the nominal result


@dataclass(frozen=True)
class Outcome:
    """The result of a gait in one world.

    Attributes:
        result: measure `forward`, or the score if the body does not have this measure.
        score: score of the motion; −inf if it failed.
        fell: whether the body fell, or the motion failed.
        failure: reason why the motion failed, or ''.
    """

    result: float
    score: float
    fell: bool
    failure: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class UnseenResults(ReprMixin):
    """The results of a gait in unseen worlds.

    Attributes:
        measure: name of the results: `forward`, or `score` if the body does not have this measure.
        unit: unit of the results.
        nominal: outcome in the gait's own world.
        ranges: range of each condition that varies, by name.
        units: unit of each of these conditions, by name.
        seed: seed of the worlds.
        worlds: unseen worlds.
        outcomes: outcome in each world.
    """

    measure: str
    unit: str
    nominal: Outcome
    ranges: Ranges
    units: Mapping[str, str]
    seed: int
    worlds: tuple[World, ...]
    outcomes: tuple[Outcome, ...]

    @cached_property
    def results(self) -> Floats:
        """The result in each world, (worlds,) float64; higher is better."""
        return np.array([one.result for one in self.outcomes])

    @cached_property
    def fell(self) -> NDArray[np.bool_]:
        """Whether the body fell in each world, (worlds,)."""
        return np.array([one.fell for one in self.outcomes])

    @property
    def falls(self) -> int:
        """The number of worlds in which the body fell."""
        return int(self.fell.sum())

    @property
    def failures(self) -> tuple[str, ...]:
        """The reasons for failed motions, in the order of the worlds."""
        return tuple(one.failure for one in self.outcomes if one.failure)

    @cached_property
    def conditions(self) -> dict[str, Floats]:
        """The values of each condition by name, (worlds,) each."""
        return {name: np.array([world[name] for world in self.worlds]) for name in self.ranges}

    @property
    def worst_tenth(self) -> float:
        """The mean of the worst tenth of the results, or of the worst one if there are few."""
        return float(worst_tenth(self.results))

    def quantile(self, share: float) -> float:
        """Return a quantile of the results, interpolated linearly."""
        if np.isfinite(self.results).all():
            return float(np.quantile(self.results, share))
        return float(np.quantile(self.results, share, method="lower"))  # cannot interpolate −inf

    @property
    def median(self) -> float:
        """The median of the results."""
        return self.quantile(0.5)

    def kept(self, result: float) -> float:
        """Return a result as a share of the nominal result; NaN if the nominal one is ≤ 0."""
        return result / self.nominal.result if self.nominal.result > 0 else math.nan

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """The conditions with a significant and relevant effect, the strongest first."""
        found = effects(self.conditions, self.ranges, self.results)
        least = NEGLIGIBLE * abs(self.nominal.result)
        return tuple(one for one in found if not one.loss < least)

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "worlds": len(self.worlds),
            "measure": self.measure,
            "nominal": self.nominal.result,
            "median": self.median,
            "worst_tenth": self.worst_tenth,
            "falls": self.falls,
            "losses": {one.condition: one.loss for one in self.effects},
        }

    @property
    def worst(self) -> World:
        """The world with the lowest result."""
        return self.worlds[int(np.argmin(self.results))]

    def to_dict(self) -> dict[str, Any]:
        """Return the statistics and all worlds as values for JSON."""
        worlds = [
            {"world": dict(world), **_to_dict(outcome)}
            for world, outcome in zip(self.worlds, self.outcomes, strict=True)
        ]
        return {**self.statistics(), "worlds": worlds}

    def statistics(self) -> dict[str, Any]:
        """Return the statistics as values for JSON, without the individual worlds."""
        return {
            "measure": self.measure,
            "unit": self.unit,
            "number": len(self.worlds),
            "seed": self.seed,
            "ranges": {name: list(ends) for name, ends in self.ranges.items()},
            "nominal": _to_dict(self.nominal),
            "worst_tenth": self.worst_tenth,
            "worst": self.quantile(0),
            "q25": self.quantile(0.25),
            "median": self.median,
            "q75": self.quantile(0.75),
            "best": self.quantile(1),
            "kept_worst_tenth": self.kept(self.worst_tenth),
            "kept_median": self.kept(self.median),
            "falls": self.falls,
            "effects": [asdict(one) for one in self.effects],
        }


def worst_tenth(results: Floats) -> Floats:
    """Return the mean of the worst tenth, rounded up, of results, (…, worlds), in shape (…)."""
    counted = -(-results.shape[-1] // 10)
    return np.asarray(np.sort(results, axis=-1)[..., :counted].mean(axis=-1))


def _to_dict(outcome: Outcome) -> dict[str, Any]:
    return {**asdict(outcome), "failure": outcome.failure or None}
