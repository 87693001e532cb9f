"""Compare experiments: statistics of repeats with equal numbers of evaluations."""

import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.runs import (
    COMMAND_LINE,
    Experiment,
    Overrides,
    command,
    differences,
    load_experiment,
    read_outline,
    scoring_warning,
    with_overrides,
)
from gaitsim_studies.runtimes import (
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
from gaitsim_studies.statistics import (
    CONFIDENCE,
    LEAST,
    Description,
    PairTest,
    TargetTest,
    compare,
    describe,
    least_p,
)


def load_experiments(
    references: str | Path | Experiment | Sequence[str | Path | Experiment],
    overrides: Overrides,
    place: str = COMMAND_LINE,
) -> dict[str, Experiment]:
    """Load experiments by label, each with its own seed, so that samples are independent.

    Experiments that share a seed get seeds derived from it and from their options; repeated names
    get numbers. Neither depends on the order of the experiments.
    """
    if isinstance(references, str | Path | Experiment) or len(references) < 2:
        raise GaitsimError(
            "a comparison needs two experiments",
            remedy="name two or more, such as: gaitsim compare millipede-random millipede-mutation",
        )
    given = [
        with_overrides(one, overrides, place)
        if isinstance(one, Experiment)
        else load_experiment(str(one), overrides, place)
        for one in references
    ]
    experiments = _with_distinct_seeds(given)
    return dict(zip(_labels(experiments), experiments, strict=True))


def _with_distinct_seeds(experiments: Sequence[Experiment]) -> list[Experiment]:
    """Return the experiments with new seeds for those that share one.

    Distinct seeds are kept, so the files that a comparison writes reproduce the comparison.
    """
    counts = Counter(one.seed for one in experiments)
    used = {seed for seed, number in counts.items() if number == 1}
    contents = [_content(one) for one in experiments]
    found = list(experiments)
    for index in sorted(
        range(len(found)),
        key=lambda i: (contents[i], found[i].seed, found[i].name, found[i].description),
    ):
        shared = found[index].seed
        if counts[shared] > 1:
            digest = hashlib.sha256(f"{shared} {contents[index]}".encode()).digest()
            seed = int.from_bytes(digest[:4], "big")  # at most ten digits, easy to copy
            while seed in used:  # taken by an equal experiment
                seed += 1
            used.add(seed)
            found[index] = with_overrides(found[index], {"seed": seed})
    return found


def _content(experiment: Experiment) -> str:
    """Return the options that distinguish experiments, as JSON.

    The number of generations is left out, because equal budgets change it.
    """
    options = experiment.to_dict()
    del options["name"], options["description"], options["seed"]
    del options["evolution"]["generations"]
    return json.dumps(options, sort_keys=True)


def _labels(experiments: Sequence[Experiment]) -> list[str]:
    """Return unique labels: repeated names get numbers, in the order of options and seeds."""
    labels: dict[int, str] = {}
    for index in sorted(
        range(len(experiments)),
        key=lambda i: (experiments[i].name, _content(experiments[i]), experiments[i].seed),
    ):
        name = label = experiments[index].name
        number = 1
        while label in labels.values():
            number += 1
            label = f"{name} ({number})"
        labels[index] = label
    return [labels[index] for index in range(len(experiments))]


def equal_budgets(
    experiments: Mapping[str, Experiment], evaluations: int | None
) -> tuple[int, dict[str, Experiment]]:
    """Return the number of evaluations per repeat, and experiments with as many generations.

    Args:
        experiments: experiments by label.
        evaluations: evaluations per repeat; None for the number in the shortest experiment.
    """
    lengths = [one.individuals * one.evolution.generations for one in experiments.values()]
    budget = min(lengths) if evaluations is None else evaluations
    label, largest = max(experiments.items(), key=lambda item: item[1].individuals)
    if budget < largest.individuals:
        raise GaitsimError(
            f"{budget:,} evaluations are not enough for one generation of {label}",
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


def experiment_texts(experiments: Mapping[str, Experiment]) -> dict[str, str]:
    """Return the experiments as the texts of files: `1.toml`, `2.toml` …"""
    return {f"{place}.toml": one.to_toml() for place, one in enumerate(experiments.values(), 1)}


def warning(experiments: Iterable[Experiment]) -> str:
    """Return a warning if the scores of experiments are not comparable, else ''."""
    outlines = [read_outline(one.to_toml(), one.name) for one in experiments]
    return scoring_warning(differences([[(1, one)] for one in outlines]))


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
    def tests(self) -> int:
        """Number of tests, which are corrected together."""
        return len(self.pairs) + 2 * len(self.target_tests)

    @property
    def notes(self) -> list[str]:
        """Limits of the results: few or failed repeats, equal scores, unreached targets."""
        found = []
        if self.repeats < LEAST:
            found.append(
                f"{self.repeats} repeats are too few for confidence intervals, except those of "
                f"success rates: with fewer than {LEAST}, even the range of all scores contains "
                f"the median with less than {100 * CONFIDENCE:.0f} % confidence."
            )
        least = least_p(self.repeats, self.tests)
        if least >= 1 - CONFIDENCE:
            found.append(
                f"{self.repeats} repeats are too few for a significant difference: with "
                f"{self.tests} tests, the smallest possible p after correction is {least:.2g}."
            )
        for label, one in self.descriptions.items():
            if one.failed:
                found.append(
                    f"Every individual failed in {one.failed} of {one.n} repeats of {label}; these "
                    "repeats have no score, and rank below all others."
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
    """Check options of a comparison, and return the targets of `--targets 1.5,2`; () for none."""
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
    """Return targets after checking them."""
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
    """
    if not any(np.isfinite(one.final).any() for one in samples.values()):
        one = next(iter(samples.values()))
        raise GaitsimError(
            "every individual failed in all repeats of all experiments, so there is no score to "
            "compare",
            remedy=f"show the reasons with: {command('run', one.experiment.name)}",
        )
    every = np.unique(targets) if targets else spaced_targets(s.best for s in samples.values())
    descriptions = {label: describe(s.final) for label, s in samples.items()}
    few = chosen_targets(targets, (one.final for one in samples.values()))
    times = {
        target: {
            label: runtimes(one.best, one.evaluations, target) for label, one in samples.items()
        }
        for target in few
    }
    pairs, target_tests = compare({label: one.final for label, one in samples.items()}, times)
    return Findings(
        samples,
        evaluations,
        descriptions,
        pairs,
        every,
        {
            label: ecdf(one.best, one.evaluations, evaluations, every)
            for label, one in samples.items()
        },
        {
            label: [summarise_target(one.best, one.evaluations, target) for target in few]
            for label, one in samples.items()
        },
        target_tests,
        bool(targets),
    )
