"""Rules for a preset: it is read, its first individuals move, and it breeds."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from gaitsim.contracts import Results
from gaitsim.evaluation import evaluate
from gaitsim.evolution.searching import ask, initial_state, tell
from gaitsim.experiment import Experiment, load_experiment, parse_experiment
from gaitsim.registry import Entry
from gaitsim.testing.report import Finding, advice, error

FEW = 3  # individuals that are evaluated; the whole population is drawn and bred


def preset_rules(entry: Entry) -> Iterator[Finding]:
    """All rules for a preset.

    Raises:
        GaitsimError: it has problems; names all of them.
    """
    experiment = load_experiment(entry.name)
    if parse_experiment(experiment.to_toml(), "again") != experiment:
        yield error(
            "options",
            "an experiment that is the same after being written and read",
            "another one",
            "give its plugins options of types that TOML has",
        )
    if not experiment.description:
        yield advice(
            "description",
            "one line about it, for 'gaitsim experiments list'",
            "none",
            f'description = "…" in {entry.name}.toml',
        )
    if experiment.name != entry.name:
        yield advice(
            "name",
            f"name = {entry.name!r}, so that its runs are found under its name",
            f"name = {experiment.name!r}",
            f"correct it in {entry.name}.toml",
        )
    result = two_generations(experiment)
    if not np.isfinite(result["scores"]).any():
        yield advice(
            "finite values",
            f"a finite score for some of {FEW} random individuals",
            "none has one",
            "choose other options of the body, or another fitness",
        )


def two_generations(experiment: Experiment) -> dict[str, Any]:
    """Return the scores of some first individuals, the second population, and some of its scores.

    Raises:
        PluginError: a plugin fails or breaks its contract; names its package.
    """
    space = experiment.space()
    first, state = ask(experiment, space, initial_state(experiment, space), None, 1)
    evaluation = evaluate(experiment, first[:FEW])
    # Made up for the search: evaluating all of them would take long.
    scores = np.sin(np.arange(len(first), dtype=np.float64))
    values = {name: np.resize(some, len(first)) for name, some in evaluation.values.items()}
    told = Results(first, scores, values)
    second, _ = ask(experiment, space, tell(experiment, space, state, told, 1), told, 2)
    return {
        "scores": evaluation.scores,
        "terms": evaluation.terms,
        "second": second,
        "second scores": evaluate(experiment, second[:FEW]).scores,
    }
