"""Comparisons of experiments in Python: `gaitsim.compare`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gaitsim.plugin import (
    ARGUMENTS,
    ComparisonPlot,
    GaitsimError,
    ReprField,
    ReprMixin,
    as_overrides,
    check_workers,
    unknown,
    warn,
)
from gaitsim.plugin.runs import Experiment
from gaitsim_studies.comparison import (
    Findings,
    Sample,
    analyse,
    check_targets,
    equal_budgets,
    load_experiments,
)
from gaitsim_studies.running import repeat_experiment

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Comparison(ReprMixin, Findings):
    """The results of a comparison, as returned by `compare`."""

    def plot(self, kind: ComparisonPlot = "ecdf", *, dark: bool = False) -> "Figure":
        """Return a plot, as drawn by `gaitsim compare`.

        Args:
            kind: 'ecdf' or 'convergence'.
            dark: whether to draw light lines on a dark background.

        Raises:
            GaitsimError: the kind is unknown.
        """
        from gaitsim.plugin.pictures import DARK, LIGHT, enable_notebook_display
        from gaitsim_studies.plots import FIGURES

        if kind not in FIGURES:
            raise unknown("kind of plot", kind, FIGURES)
        theme = DARK if dark else LIGHT
        return enable_notebook_display(FIGURES[kind](self, theme), theme)

    @classmethod
    def of(cls, findings: Findings) -> Self:
        """Return findings as a comparison, which has plots."""
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

    The same arguments give bit-identical results, in Python and on the command line. The order of
    the experiments does not affect the results of an experiment or a test.

    Args:
        experiments: two or more names of presets, paths of TOML files or robot files, or
            experiments.
        repeats: repeats of each experiment, at least 2. Intervals of medians, running times and
            effect sizes need 6, those of areas 20.
        evaluations: evaluations per repeat; None for the number in the shortest experiment.
        targets: scores to reach, for the ECDF, the expected running times and their tests. ()
            uses 51 equally spaced targets for the ECDF, and the quartiles of the scores of all
            repeats for the running times and tests.
        set: options of all experiments by key, such as `{"evolution.population": 50}`.
        workers: number of parallel workers; None chooses the body's default.

    Raises:
        ExperimentError: an experiment has problems.
        GaitsimError: an argument is invalid, or no repeat has a score.
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
            f"invalid number of {name}: {value!r}", where=name, allowed=f"a whole number ≥ {least}"
        )
