"""Checks of a preset: its file, its first individuals, and its second population."""

import numpy as np
import pytest

from gaitsim.plugin import EXPERIMENTS, Entry, Results
from gaitsim.plugin.runs import (
    Experiment,
    ask,
    evaluate_experiment as evaluate,
    initial_state,
    load_experiment,
    parse_experiment,
    tell,
)
from gaitsim_testing.finding import advise, require

KINDS = (EXPERIMENTS,)
FEW = 3  # first individuals that move, and one that was bred; whole populations are drawn and bred


@pytest.fixture(scope="session")
def experiment(entry: Entry) -> Experiment:
    """The experiment of the preset."""
    return load_experiment(entry.name)


def test_file(entry: Entry, experiment: Experiment) -> None:
    """The file is the same after writing and reading, and names and describes the preset."""
    require(
        parse_experiment(experiment.to_toml(), "again") == experiment,
        "a different experiment after writing and reading a file",
        "the same experiment",
        "use option types that TOML supports in its plugins",
    )
    file = f"in {entry.name}.toml"
    advise(
        experiment.description,
        "no description",
        "a description on one line, for 'gaitsim experiments list'",
        f'description = "…" {file}',
    )
    advise(
        experiment.name == entry.name,
        f"name = {experiment.name!r}",
        f"name = {entry.name!r}, so that runs have the name of the preset",
        f"correct it {file}",
    )


def test_two_generations(experiment: Experiment) -> None:
    """The first individuals move, and a second population can be bred."""
    space = experiment.space()
    first, state = ask(experiment, space, initial_state(experiment, space), None, 1)
    evaluation = evaluate(experiment, first[:FEW])
    advise(
        np.isfinite(evaluation.scores).any(),
        "no finite score",
        f"a finite score for some of {FEW} random individuals",
        "change the options of the body, or the fitness",
    )
    # Artificial scores for the search, because evaluating the whole population could be slow.
    scores = np.sin(np.arange(len(first), dtype=np.float64))
    values = {name: np.resize(some, len(first)) for name, some in evaluation.values.items()}
    results = Results(first, scores, values)
    second, _ = ask(experiment, space, tell(experiment, space, state, results, 1), results, 2)
    evaluate(experiment, second[-1:])
