"""The experiments of a comparison, with labels, independent seeds and equal budgets."""

import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.experiment import (
    Experiment,
    Overrides,
    load_experiment,
    read_outline,
    with_overrides,
)
from gaitsim.experiment.overrides import COMMAND_LINE
from gaitsim.study.differences import differences, scoring_warning


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


def warning(experiments: Iterable[Experiment]) -> str:
    """Return a warning if the scores of experiments are not comparable, else ''."""
    outlines = [read_outline(one.to_toml(), one.name) for one in experiments]
    return scoring_warning(differences([[(1, one)] for one in outlines]))
