"""The conditions that end a search.

This module imports nothing heavy, as `gaitsim runs` needs it.
"""

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


class Reached(Protocol):
    """The progress of a search."""

    @property
    def evaluations(self) -> int:
        """The number of individuals evaluated."""

    @property
    def best_score(self) -> float:
        """The best score so far."""

    @property
    def stagnation(self) -> int:
        """The number of generations since the best score last increased."""


def stop_reason(limits: Limits, number: int, progress: Reached, individuals: int) -> str:
    """Return why a search ends after generation `number`; '' if it continues."""
    if number >= limits.generations:
        return f"{number} generations are done"
    target = limits.target_score
    if target is not None and progress.best_score >= target:
        return f"the target score {target:g} is reached"
    limit = limits.max_evaluations
    if limit is not None and progress.evaluations + individuals > limit:
        return f"another generation would exceed {limit} evaluations"
    if limits.stagnation is not None and progress.stagnation >= limits.stagnation:
        return f"no better score for {progress.stagnation} generations"
    return ""
