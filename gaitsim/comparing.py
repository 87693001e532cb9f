"""Comparisons of experiments in Python: `gaitsim.compare`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gaitsim.arguments import ARGUMENTS, as_overrides, check_workers, warn
from gaitsim.choices import ComparisonPlot
from gaitsim.errors import GaitsimError, unknown
from gaitsim.experiment import Experiment
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.study.comparison import (
    Findings,
    Sample,
    analyse,
    check_targets,
)
from gaitsim.study.competitors import equal_budgets, load_experiments
from gaitsim.study.running import repeat_experiment

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Comparison(ReprMixin, Findings):
    """The results of a comparison, as `compare` returns them."""

    def plot(self, kind: ComparisonPlot = "ecdf", *, dark: bool = False) -> "Figure":
        """Return a plot, as `gaitsim compare` draws it.

        Args:
            kind: 'ecdf' or 'convergence'.
            dark: light lines on a dark ground.

        Raises:
            GaitsimError: there is no such kind.
        """
        from gaitsim.render.notebook import shown_in_notebooks
        from gaitsim.render.plots.comparison import FIGURES
        from gaitsim.render.plots.style import DARK, LIGHT

        if kind not in FIGURES:
            raise unknown("kind of plot", kind, FIGURES)
        theme = DARK if dark else LIGHT
        return shown_in_notebooks(FIGURES[kind](self, theme), theme)

    @classmethod
    def of(cls, findings: Findings) -> Self:
        """Return findings with plots."""
        return cls(**vars(findings))

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "evaluations": self.evaluations,
            "repeats": self.repeats,
            "median": {label: one.median for label, one in self.descriptions.items()},
            "area": {label: one.area for label, one in self.ecdfs.items()},
            **({"warning": self.warning} if self.warning else {}),
        }


def compare(
    experiments: Sequence[str | Path | Experiment],
    *,
    repeats: int = 30,
    evaluations: int | None = None,
    targets: Sequence[float] = (),
    set: Mapping[str, Any] | None = None,
    workers: int | None = None,
) -> Comparison:
    """Repeat experiments with equal numbers of evaluations, and compare them.

    The same arguments give the same results to the last bit, in Python as on the command line.
    The order of the experiments changes no number of an experiment or a test.

    Args:
        experiments: two or more names of presets, paths of TOML files or robots' files, or
            experiments.
        repeats: of each, at least two: one allows no interval and no test.
        evaluations: of each repeat; None for those of the shortest experiment.
        targets: scores to reach, for the ECDF, the expected running times and their tests; ()
            for 51 at equal distances, and for the quartiles of all repeats' scores together.
        set: options of all experiments by key, such as `{"evolution.population": 50}`.
        workers: number of parallel workers; None for what suits the body.

    Raises:
        ExperimentError: an experiment has problems.
        GaitsimError: an argument is invalid, or a repeat has no score.
    """
    check_workers(workers)
    _check_count("repeats", repeats, 2)
    if evaluations is not None:
        _check_count("evaluations", evaluations, 1)
    aims = check_targets(targets)
    loaded = load_experiments(experiments, as_overrides(set, {}), ARGUMENTS)
    budget, shortened = equal_budgets(loaded, evaluations)
    samples = {
        label: Sample(one, repeat_experiment(one, repeats, workers=workers, on_warning=warn))
        for label, one in shortened.items()
    }
    found = Comparison.of(analyse(samples, budget, aims))
    if found.warning:
        warn(found.warning)
    return found


def _check_count(name: str, value: Any, least: int) -> None:
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < least:
        raise GaitsimError(
            f"{value!r} is not a number of {name}", where=name, allowed=f"a whole number ≥ {least}"
        )
