"""Compare experiments: statistics of repeats with equal numbers of evaluations."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment
from gaitsim.study.competitors import warning
from gaitsim.study.runtimes import (
    GIVEN,
    QUARTILES,
    SPACED,
    Ecdf,
    TargetSummary,
    chosen_targets,
    ecdf,
    runtimes,
    spaced_targets,
    summarise_target,
    target_text,
)
from gaitsim.study.statistics import (
    CONFIDENCE,
    Description,
    PairTest,
    compare,
    describe,
    least_p,
)
from gaitsim.study.target_tests import TargetTest, compare_times

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
        """Number of evaluations of one repeat so far, (generations,)."""
        return self.experiment.individuals * np.arange(1, self.best.shape[1] + 1)

    @property
    def final(self) -> NDArray[np.float64]:
        """Best score of each repeat, (repeats,)."""
        return self.best[:, -1]


@dataclass(frozen=True, eq=False)
class Findings:
    """The results of a comparison, by the labels of the experiments.

    Attributes:
        samples: repeats of each experiment.
        evaluations: budget of each repeat; whole generations may use fewer evaluations.
        descriptions: descriptive statistics of the final scores.
        pairs: tests of every pair of experiments.
        targets: target scores of the ECDF, ascending.
        ecdfs: ECDFs of runtimes over these targets.
        reached: summary of how often and how soon the repeats reach each target of the expected
            running times.
        target_tests: tests of every pair of experiments at each of these targets.
        targets_given: whether the user gave the targets, which then serve both purposes.
    """

    samples: Mapping[str, Sample]
    evaluations: int
    descriptions: Mapping[str, Description]
    pairs: Sequence[PairTest]
    targets: NDArray[np.float64]
    ecdfs: Mapping[str, Ecdf]
    reached: Mapping[str, Sequence[TargetSummary]]
    target_tests: Sequence[TargetTest]
    targets_given: bool

    @property
    def ecdf_rule(self) -> str:
        """Rule that chose the targets of the ECDF."""
        return GIVEN if self.targets_given else SPACED

    @property
    def ert_rule(self) -> str:
        """Rule that chose the targets of the expected running times and of their tests."""
        return GIVEN if self.targets_given else QUARTILES

    @property
    def ert_targets(self) -> list[float]:
        """Targets of the expected running times, ascending."""
        return [one.target for one in next(iter(self.reached.values()))]

    @property
    def warning(self) -> str:
        """Reason why the scores are not comparable, or ''."""
        return warning(one.experiment for one in self.samples.values())

    @property
    def repeats(self) -> int:
        """Number of repeats of each experiment."""
        return len(next(iter(self.samples.values())).best)

    @property
    def notes(self) -> list[str]:
        """Limits of the results: too few repeats, equal scores, unreached targets."""
        found = []
        for tests, what in (
            (len(self.pairs), "best scores"),
            (len(self.target_tests), "successes and times at the targets"),
        ):
            least = least_p(self.repeats, tests)
            if tests and least >= 1 - CONFIDENCE:
                found.append(
                    f"{self.repeats} repeats are too few for a significant difference of {what}: "
                    f"with {tests} test{'s' * (tests != 1)}, the smallest possible p after "
                    f"correction is {least:.2g}."
                )
        finals = np.concatenate([one.final for one in self.samples.values()])
        if finals.min() == finals.max():
            found.append(
                f"All repeats of all experiments have the same best score, {finals[0]:.6g}, so "
                "only the running times can differ."
            )
        missed = [target for target in self.ert_targets if target > finals.max()]
        if missed:
            which = target_text(missed[0]) + (" or any higher target" if len(missed) > 1 else "")
            found.append(
                f"No repeat of any experiment reaches {which}, so its running times are infinite "
                f"and its tests have p = 1; the highest score is {finals.max():.6g}."
            )
        return found


def check_request(
    targets: str | None, evaluations: int | None, generations: int | None
) -> tuple[float, ...]:
    """Check options of a comparison, and return the targets of `--targets 1.5,2`; () for none.

    Raises:
        GaitsimError: the targets are not numbers, or both evaluations and generations are given.
    """
    if evaluations is not None and generations is not None:
        raise GaitsimError(
            "'evaluations' and 'generations' cannot be combined",
            where="--evaluations, --generations",
            remedy="omit one of the two",
        )
    if targets is None:
        return ()
    try:
        return check_targets([float(part) for part in targets.split(",")])
    except ValueError:
        raise GaitsimError(
            f"invalid list of scores: {targets!r}",
            where="--targets",
            allowed="numbers separated by commas, such as 1.5,2,2.5",
        ) from None


def check_targets(targets: ArrayLike) -> tuple[float, ...]:
    """Return targets after checking them.

    Raises:
        GaitsimError: a target is not a finite number, or there are too many targets.
    """
    every = np.atleast_1d(np.asarray(targets, dtype=object)).tolist()
    for target in every:
        if not isinstance(target, int | float) or not math.isfinite(target):
            raise GaitsimError(
                f"invalid target: {target!r}", where="targets", allowed="finite numbers"
            )
    if len(every) > MOST_TARGETS:
        raise GaitsimError(
            f"{len(every):,} targets are too many",
            where="targets",
            allowed=f"at most {MOST_TARGETS}",
        )
    return tuple(map(float, every))


def analyse(
    samples: Mapping[str, Sample], evaluations: int, targets: Sequence[float] = ()
) -> Findings:
    """Describe and compare samples.

    Args:
        samples: repeats of the experiments, by label.
        evaluations: budget of each repeat.
        targets: scores to reach; () for 51 equally spaced targets of the ECDF, and the quartiles
            of the final scores of all experiments for the expected running times.

    Raises:
        GaitsimError: a repeat has no finite score to compare.
    """
    for label, one in samples.items():
        if not np.isfinite(one.final).all():
            failed = int((~np.isfinite(one.final)).sum())
            raise GaitsimError(
                f"every individual failed in {failed} of {len(one.final)} repeats of {label}, "
                "so these repeats have no score to compare",
                remedy=f"show the reasons with: gaitsim run {one.experiment.name}",
            )
    every = np.unique(targets) if targets else spaced_targets(s.best for s in samples.values())
    descriptions = {label: describe(s.final, _stream(s)) for label, s in samples.items()}
    few = chosen_targets(targets, (one.final for one in samples.values()))
    times = {
        target: {
            label: runtimes(one.best, one.evaluations, target) for label, one in samples.items()
        }
        for target in few
    }
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
        compare_times(times),
        bool(targets),
    )


def _stream(sample: Sample) -> np.random.Generator:
    # The seed makes results independent of the order and number of experiments and targets.
    return np.random.default_rng([sample.experiment.seed, len(sample.final)])
