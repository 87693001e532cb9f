"""Curves, for terminals and figures."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    from gaitsim.storage.compare_runs import ComparedRun


@dataclass(frozen=True, eq=False)
class Series:
    """One curve.

    Attributes:
        name: name in the legend.
        x: (points,), in ascending order.
        y: (points,); values that are not finite leave gaps.
        stages: ascending indices of the points at which the later stages begin. The line is
            broken there, as the fitness may differ.
        incomparable: whether the values cannot be compared with the other curves. The
            curve is then drawn faint, each stage on its own scale.
    """

    name: str
    x: NDArray[Any]
    y: NDArray[Any]
    stages: tuple[int, ...] = ()
    incomparable: bool = False


def run_curves(runs: Iterable["ComparedRun"], quantity: str, by: str) -> list[Series]:
    """Return the curve of each run with at least one generation, for terminals and figures.

    Args:
        runs: the runs to compare.
        quantity: vertical axis, a name in `gaitsim.storage.compare_runs.QUANTITIES`.
        by: horizontal axis, a name in `gaitsim.storage.compare_runs.AXES`.
    """
    return [
        Series(one.label, one.axis(by), one.history[quantity], one.stage_starts)
        for one in runs
        if one.history
    ]
