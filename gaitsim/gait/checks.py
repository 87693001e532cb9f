"""Whether a gait holds: how much of its distance it keeps in the worlds that its body names."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from gaitsim.contracts import check_world
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import World, conditions_of, describe, has_worlds
from gaitsim.experiment import Experiment
from gaitsim.gait.unseen import Outcome, evaluate_in, measure_of, outcome_of
from gaitsim.individual import Individual
from gaitsim.registry import contract_error, plugin_errors
from gaitsim.repr_mixin import ReprField, ReprMixin

HOLDS = 0.75
"""Least share of its nominal result that a gait that holds keeps in each check."""


@dataclass(frozen=True)
class Check:
    """The result of a gait in one of the worlds that its body names.

    Attributes:
        world: values of conditions by name.
        outcome: outcome in this world.
        kept: result as a share of the nominal result; 0 if the motion failed, and NaN if the
            nominal result is ≤ 0.
        varied: descriptions of the conditions, such as 'friction of the feet on the ground'.
    """

    world: World
    outcome: Outcome
    kept: float
    varied: str = ""

    @property
    def name(self) -> str:
        """The world in words, such as 'friction 0.4'."""
        return describe(self.world)

    @property
    def passed(self) -> bool:
        """Whether the body stays upright and keeps at least `HOLDS` of its result."""
        return not self.outcome.fell and self.kept >= HOLDS


@dataclass(frozen=True, repr=False)
class CheckResults(ReprMixin):
    """The results of a gait in all worlds that its body names.

    Attributes:
        measure: name of the results: `forward`, or `score` if the body does not have this measure.
        unit: unit of the results.
        nominal: outcome in the gait's own world.
        checks: results, at least one.
    """

    measure: str
    unit: str
    nominal: Outcome
    checks: tuple[Check, ...]

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that the gait does not pass."""
        return tuple(one for one in self.checks if not one.passed)

    @property
    def holds(self) -> bool:
        """Whether the gait passes all checks, and stays upright in its own world."""
        return not self.failed and not self.nominal.fell

    @property
    def worst(self) -> Check:
        """The check in which the gait keeps least; one with a fall, if there is any."""
        return min(self.checks, key=lambda one: (not one.outcome.fell, one.kept))

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The conditions of the failed checks, such as 'friction of the feet on the ground'."""
        return tuple(dict.fromkeys(one.varied for one in self.failed if one.varied))

    @property
    def summary(self) -> str:
        """Return the results on one line, such as 'Holds: keeps 86 % of 4.40 m in …'."""
        if not self.nominal.result > 0:
            return "Not checked in other worlds, as the gait does not move forward in its own."
        if self.nominal.fell:
            return "Does not hold: falls in its own world."
        total, worst = f"{self.nominal.result:.2f} {self.unit}".rstrip(), self.worst
        count = f"{len(self.checks)} checks"
        kept = f"keeps {100 * worst.kept:.0f} % of {total}"
        if self.holds:
            return f"Holds: {kept} in the worst of {count} ({worst.name})."
        falls = " and falls" if worst.outcome.fell else ""
        return f"Does not hold: {kept}{falls} at {worst.name}; fails {len(self.failed)} of {count}."

    def to_dict(self) -> dict[str, Any]:
        """Return the results as values for JSON."""
        return {
            "measure": self.measure,
            "unit": self.unit,
            "nominal": self.nominal.to_dict(),
            "holds": self.holds,
            "depends_on": list(self.depends_on),
            "checks": [
                {
                    "world": dict(one.world),
                    **one.outcome.to_dict(),
                    "kept": one.kept,
                    "passed": one.passed,
                }
                for one in self.checks
            ],
        }

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "holds": self.holds,
            "measure": self.measure,
            "nominal": self.nominal.result,
            "kept": {one.name: one.kept for one in self.checks},
        }


def worlds_of(experiment: Experiment) -> tuple[World, ...]:
    """Return the worlds that a body names as checks.

    Raises:
        PluginError: the body fails, or names a world that it does not have.
    """
    entry, body = experiment.entries["organism"], experiment.organism
    with plugin_errors(entry, "naming its checks"):
        worlds = tuple(body.checks())
        conditions = body.conditions() if worlds and has_worlds(experiment) else {}
        for world in worlds:
            try:
                check_world(world, conditions)
            except GaitsimError as error:
                what = f"names an invalid check: {error.what}"
                raise contract_error(entry, what, error.allowed) from None
    return worlds


def check_gait(
    individual: Individual,
    *,
    workers: int | None = None,
    advance: Callable[[int], object] = lambda worlds: None,
) -> CheckResults | None:
    """Move a gait in the worlds in which its body says that a good gait still works.

    Args:
        individual: individual of a run or from a file.
        workers: number of workers; None for a number that suits the body.
        advance: called with the number of worlds that were completed since the last call.

    Returns:
        None for a body that names no such worlds.

    Raises:
        PluginError: the body or the fitness fails or breaks its contract.
    """
    worlds = worlds_of(individual.experiment)
    if not worlds:
        return None
    conditions = conditions_of(individual.experiment)
    nominal = outcome_of(individual)
    outcomes = evaluate_in(individual, worlds, workers, advance, outcome_of)
    checks = tuple(
        Check(
            world,
            one,
            _kept(one.result, nominal.result),
            ", ".join(conditions[name].help for name in world if name in conditions),
        )
        for world, one in zip(worlds, outcomes, strict=True)
    )
    return CheckResults(*measure_of(individual), nominal, checks)


def _kept(result: float, nominal: float) -> float:
    if not nominal > 0:
        return math.nan
    return result / nominal if math.isfinite(result) else 0.0
