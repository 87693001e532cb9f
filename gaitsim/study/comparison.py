"""Compare experiments: repeats with equal numbers of evaluations, and their statistics."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.errors import GaitsimError
from gaitsim.experiment import (
    Experiment,
    Overrides,
    load_experiment,
    read_outline,
    with_overrides,
)
from gaitsim.experiment.problems import COMMAND_LINE
from gaitsim.study.differences import differences, scoring_warning
from gaitsim.study.runtimes import (
    Ecdf,
    TargetSummary,
    chosen_targets,
    ecdf,
    spaced_targets,
    summarise_target,
)
from gaitsim.study.statistics import Description, PairTest, compare, describe

MOST_TARGETS = 100


@dataclass(frozen=True, eq=False)
class Sample:
    """The repeats of one experiment.

    Attributes:
        experiment: the experiment.
        best: best score so far, (repeats, generations).
    """

    experiment: Experiment
    best: NDArray[np.float64]

    @property
    def evaluations(self) -> NDArray[np.int64]:
        """The number of evaluations of one repeat so far, (generations,)."""
        return self.experiment.individuals * np.arange(1, self.best.shape[1] + 1)

    @property
    def final(self) -> NDArray[np.float64]:
        """The best score of each repeat, (repeats,)."""
        return self.best[:, -1]


@dataclass(frozen=True, eq=False)
class Findings:
    """The results of a comparison, by the labels of the experiments.

    Attributes:
        samples: the repeats.
        evaluations: how many each repeat was allowed; its generations hold at most as many.
        descriptions: descriptive statistics of the final scores.
        pairs: a test of every pair.
        targets: scores of the ECDF, ascending.
        ecdfs: the ECDF of runtimes over these targets.
        reached: how often, and how soon, the repeats reach each of a few targets.
    """

    samples: Mapping[str, Sample]
    evaluations: int
    descriptions: Mapping[str, Description]
    pairs: Sequence[PairTest]
    targets: NDArray[np.float64]
    ecdfs: Mapping[str, Ecdf]
    reached: Mapping[str, Sequence[TargetSummary]]

    @property
    def warning(self) -> str:
        """Why the scores do not compare; '' where they do."""
        return warning(one.experiment for one in self.samples.values())

    @property
    def repeats(self) -> int:
        """The number of repeats of each experiment."""
        return len(next(iter(self.samples.values())).best)


def load_experiments(
    references: str | Path | Experiment | Sequence[str | Path | Experiment],
    overrides: Overrides,
    place: str = COMMAND_LINE,
) -> dict[str, Experiment]:
    """Load experiments by label, each with a seed of its own, so that samples are independent.

    A repeated seed becomes the next free one, and a repeated name gets a number.

    Raises:
        GaitsimError: there are fewer than two experiments, or one has problems.
    """
    if isinstance(references, str | Path | Experiment) or len(references) < 2:
        raise GaitsimError(
            "one experiment cannot be compared",
            allowed="two or more, as: gaitsim compare millipede-random millipede-mutation",
        )
    found: dict[str, Experiment] = {}
    seeds: set[int] = set()
    for reference in references:
        if isinstance(reference, Experiment):
            experiment = with_overrides(reference, overrides, place)
        else:
            experiment = load_experiment(str(reference), overrides, place)
        seed = experiment.seed
        while seed in seeds:
            seed = (seed + 1) % 2**63
        seeds.add(seed)
        if seed != experiment.seed:
            experiment = with_overrides(experiment, {"seed": seed})
        label, number = experiment.name, 1
        while label in found:
            number += 1
            label = f"{experiment.name} ({number})"
        found[label] = experiment
    return found


def equal_budgets(
    experiments: Mapping[str, Experiment], evaluations: int | None
) -> tuple[int, dict[str, Experiment]]:
    """Return the evaluations of each repeat, and the experiments with generations for no more.

    Args:
        experiments: by label.
        evaluations: of each repeat; None for those of the shortest experiment.

    Raises:
        GaitsimError: they are fewer than a generation of an experiment.
    """
    lengths = [one.individuals * one.evolution.generations for one in experiments.values()]
    budget = min(lengths) if evaluations is None else evaluations
    label, largest = max(experiments.items(), key=lambda item: item[1].individuals)
    if budget < largest.individuals:
        raise GaitsimError(
            f"{budget:,} evaluations are fewer than a generation of {label}",
            where="evaluations",
            allowed=f"a whole number ≥ {largest.individuals:,}",
            remedy="allow more evaluations, or make the population smaller",
        )
    return budget, {
        label: with_overrides(
            one, {"evolution.generations": budget // one.individuals}, "evaluations"
        )
        for label, one in experiments.items()
    }


def check_request(
    targets: str | None, evaluations: int | None, generations: int | None
) -> tuple[float, ...]:
    """Return the targets of `--targets 1.5,2`, () for none, after a check of all three options.

    Raises:
        GaitsimError: the targets are not numbers, or both evaluations and generations are given.
    """
    if evaluations is not None and generations is not None:
        raise GaitsimError(
            "evaluations and generations are both given",
            where="--evaluations, --generations",
            allowed="one of the two",
        )
    if targets is None:
        return ()
    try:
        return check_targets([float(part) for part in targets.split(",")])
    except ValueError:
        raise GaitsimError(
            f"{targets!r} is not a list of scores",
            where="--targets",
            allowed="numbers with commas between them, such as 1.5,2,2.5",
        ) from None


def check_targets(targets: ArrayLike) -> tuple[float, ...]:
    """Return targets after a check.

    Raises:
        GaitsimError: one is not a finite number, or there are too many.
    """
    every = np.atleast_1d(np.asarray(targets, dtype=object)).tolist()
    for target in every:
        if not isinstance(target, int | float) or not math.isfinite(target):
            raise GaitsimError(
                f"{target!r} is not a score", where="targets", allowed="finite numbers"
            )
    if len(every) > MOST_TARGETS:
        raise GaitsimError(
            f"{len(every):,} targets are too many", where="targets", allowed=f"≤ {MOST_TARGETS}"
        )
    return tuple(map(float, every))


def warning(experiments: Iterable[Experiment]) -> str:
    """Return a warning where the scores of experiments do not compare; '' where they do."""
    outlines = [read_outline(one.to_toml(), one.name) for one in experiments]
    return scoring_warning(differences([[(1, one)] for one in outlines]))


def analyse(
    samples: Mapping[str, Sample], evaluations: int, targets: Sequence[float] = ()
) -> Findings:
    """Describe and compare samples.

    Args:
        samples: by label.
        evaluations: how many each repeat was allowed.
        targets: scores to reach; () for 51 at equal distances in the ECDF, and the median of
            each experiment for the expected running times.

    Raises:
        GaitsimError: a repeat has no finite score to compare.
    """
    for label, one in samples.items():
        if not np.isfinite(one.final).all():
            raise GaitsimError(
                f"every individual failed in a repeat of {label}, which has no score to compare",
                remedy=f"see why with: gaitsim run {one.experiment.name}",
            )
    every = np.unique(targets) if targets else spaced_targets(s.best for s in samples.values())
    descriptions = {label: describe(s.final, _stream(s)) for label, s in samples.items()}
    few = chosen_targets(targets, (one.median for one in descriptions.values()))
    return Findings(
        samples,
        evaluations,
        descriptions,
        compare({label: one.final for label, one in samples.items()}),
        every,
        {
            label: ecdf(one.best, one.evaluations, evaluations, every, _stream(one))
            for label, one in samples.items()
        },
        {
            label: [
                summarise_target(one.best, one.evaluations, target, _stream(one)) for target in few
            ]
            for label, one in samples.items()
        },
    )


def _stream(sample: Sample) -> np.random.Generator:
    # By seed, so that neither the order nor the number of experiments and targets matters.
    return np.random.default_rng([sample.experiment.seed, len(sample.final)])
