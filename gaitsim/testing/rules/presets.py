"""Rules for a preset: it can be read, moves its first individuals, and breeds a generation."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from gaitsim.contracts import Results
from gaitsim.evaluation import evaluate
from gaitsim.evolution.searching import ask, initial_state, tell
from gaitsim.experiment import Experiment, load_experiment, parse_experiment
from gaitsim.registry import Entry
from gaitsim.testing.report import Finding, advice, error

FEW = 3  # number of individuals evaluated; the whole population is drawn and bred


def preset_rules(entry: Entry) -> Iterator[Finding]:
    """Check all rules for a preset."""
    experiment = load_experiment(entry.name)
    if parse_experiment(experiment.to_toml(), "again") != experiment:
        yield error(
            "options",
            "the same experiment after writing and reading a file",
            "a different experiment",
            "use option types that TOML supports in its plugins",
        )
    if not experiment.description:
        yield advice(
            "description",
            "a description on one line, for 'gaitsim experiments list'",
            "none",
            f'description = "…" in {entry.name}.toml',
        )
    if experiment.name != entry.name:
        yield advice(
            "name",
            f"name = {entry.name!r}, so that runs have the name of the preset",
            f"name = {experiment.name!r}",
            f"correct it in {entry.name}.toml",
        )
    result = two_generations(experiment)
    if not np.isfinite(result["scores"]).any():
        yield advice(
            "finite values",
            f"a finite score for some of {FEW} random individuals",
            "no finite score",
            "change the options of the body, or the fitness",
        )


def two_generations(experiment: Experiment) -> dict[str, Any]:
    """Return scores from the first generation, the second population, and some of its scores."""
    space = experiment.space()
    first, state = ask(experiment, space, initial_state(experiment, space), None, 1)
    evaluation = evaluate(experiment, first[:FEW])
    # Artificial scores for the search, because evaluating the whole population could be slow.
    scores = np.sin(np.arange(len(first), dtype=np.float64))
    values = {name: np.resize(some, len(first)) for name, some in evaluation.values.items()}
    results = Results(first, scores, values)
    second, _ = ask(experiment, space, tell(experiment, space, state, results, 1), results, 2)
    return {
        "scores": evaluation.scores,
        "terms": evaluation.terms,
        "second": second,
        "second scores": evaluate(experiment, second[:FEW]).scores,
    }
