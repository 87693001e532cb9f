import numpy as np
import pytest
from scipy.stats import binomtest

from breeding import breed, initial_population
from gaitsim.contracts import RealSpace
from gaitsim.errors import PluginError
from gaitsim.evaluation.streams import Purpose, stream
from gaitsim.evolution.context import ExperimentOperators
from gaitsim.experiment import load_experiment

SCORES = np.array([0.5, 2.0, -np.inf, 2.0, -1.0, 0.0])


def bred(experiment, generation=2, scores=SCORES):
    space = experiment.space()
    genomes = initial_population(experiment, space)
    return genomes, breed(experiment, space, genomes, scores, generation)


def test_the_initial_population_is_drawn_by_the_seed(puppet):
    space = puppet().space()
    one = initial_population(puppet(), space)
    assert one.shape == (6, 3)
    assert space.contains(one)
    assert np.array_equal(one, initial_population(puppet(), space))
    assert not np.array_equal(one, initial_population(puppet("seed=2"), space))


@pytest.mark.parametrize("probability", [0.0, 0.6, 0.9])
def test_pairs_that_are_not_crossed_have_copies_for_children(probability):
    options = {
        "crossover.plugin": "blend",
        "crossover.pair_probability": probability,
        "search.start": "random",
    }
    experiment, pairs = load_experiment("spider-genetic", options), 20_000
    space = experiment.space()
    genomes = initial_population(experiment, space)
    parents = np.random.default_rng(0).permuted(np.tile(np.arange(9), (pairs, 1)), axis=1)[:, :2]
    children = ExperimentOperators(experiment, space, 2).cross(genomes, parents, 2 * pairs)
    copied = (children.reshape(2, pairs, -1) == genomes[parents.T]).all(axis=2)
    assert np.array_equal(*copied)
    assert binomtest(pairs - copied[0].sum(), pairs, probability).pvalue > 1e-3


def test_streams_differ_by_seed_generation_and_purpose():
    draws = {
        stream(seed, generation, purpose).random()
        for seed in (0, 1)
        for generation in (1, 2)
        for purpose in Purpose
    }
    assert len(draws) == 2 * 2 * len(Purpose)
    assert stream(0, 1, Purpose.INITIAL).random() in draws


def test_a_step_is_a_function_of_its_arguments_and_changes_none_of_them(puppet):
    space, scores = puppet().space(), SCORES.copy()
    genomes = initial_population(puppet(), space)
    before = genomes.copy()
    one = breed(puppet(), space, genomes, scores, 2)
    assert np.array_equal(one, breed(puppet(), space, genomes, scores, 2))
    assert not np.array_equal(one, breed(puppet(), space, genomes, scores, 3))
    assert np.array_equal(genomes, before)
    assert np.array_equal(scores, SCORES)
    assert not np.shares_memory(one, genomes)


def test_elites_come_first_and_unchanged_the_first_of_equals_first(puppet):
    genomes, after = bred(puppet("search.elites=3"))
    assert np.array_equal(after[:3], genomes[[1, 3, 0]])
    assert not any((child == genomes).all(axis=1).any() for child in after[3:])


def test_children_outside_the_bounds_are_repaired(puppet, puppets, monkeypatch):
    monkeypatch.setattr(puppets.Jitter, "mutate", lambda self, genomes, space, rng: genomes + 100)
    genomes, after = bred(puppet())
    assert (after[2:] == 2.0).all()
    assert np.array_equal(after[:2], genomes[[1, 3]])


def test_operators_that_change_what_they_are_given_change_nothing_else(
    puppet, puppets, monkeypatch
):
    honest, real = bred(puppet()), puppets.Best.parents

    def parents(self, scores, pairs, rng):
        chosen = real(self, scores, pairs, rng)
        scores.sort()
        return chosen

    def cross(self, mothers, fathers, space, rng):
        mothers += fathers
        mothers /= 2
        return np.concatenate([mothers] * 2)

    def mutate(self, genomes, space, rng):
        genomes += rng.normal(0, 0.3, genomes.shape)
        return genomes

    monkeypatch.setattr(puppets.Best, "parents", parents)
    monkeypatch.setattr(puppets.Mean, "cross", cross)
    monkeypatch.setattr(puppets.Jitter, "mutate", mutate)
    scores = SCORES.copy()
    assert np.array_equal(bred(puppet(), scores=scores), honest)
    assert np.array_equal(scores, SCORES)


def fail(*arguments):
    raise ZeroDivisionError("by nought")


def returns(value):
    return lambda *arguments: value


WRONG = {
    "selection raises": ("Best", "parents", fail, "ZeroDivisionError: by nought"),
    "selection, shape": ("Best", "parents", returns(np.zeros(2, int)), r"shape \(2,\)"),
    "selection, dtype": ("Best", "parents", returns(np.zeros((2, 2))), "dtype float64"),
    "selection, nothing": ("Best", "parents", returns(None), "returned NoneType"),
    "selection, nobody": ("Best", "parents", returns(np.full((2, 2), 6)), "parents 6 to 6"),
    "crossover, too few": ("Mean", "cross", returns(np.zeros((2, 3))), r"shape \(2, 3\)"),
    "mutation, dtype": ("Jitter", "mutate", returns(np.zeros((4, 3), "f4")), "dtype float32"),
    "mutation, infinite": ("Jitter", "mutate", returns(np.full((4, 3), np.inf)), "not finite"),
    "mutation's schedule": ("Jitter", "at", fail, "applying its schedule"),
}


@pytest.mark.parametrize(("plugin", "method", "wrong", "says"), WRONG.values(), ids=WRONG.keys())
def test_an_operator_that_breaks_its_contract_is_named(
    puppet, puppets, monkeypatch, plugin, method, wrong, says
):
    experiment = puppet()
    monkeypatch.setattr(getattr(puppets, plugin), method, wrong)
    with pytest.raises(PluginError, match=says) as error:
        bred(experiment)
    kind = {"Best": "selection", "Mean": "crossover", "Jitter": "mutation"}[plugin]
    assert error.value.what.startswith(f"{kind} 'puppet-")
    assert "of package gaitsim-puppets 1.0" in error.value.what
    assert error.value.remedy


@pytest.mark.parametrize(
    ("method", "wrong", "says"),
    [
        ("random", lambda *a: np.full((6, 3), 9.0), "draws genomes"),
        ("random", fail, "drawing genomes"),
        ("repair", lambda self, genomes: genomes + 9, "repairs genomes"),
        ("repair", fail, "repairing genomes"),
    ],
)
def test_an_error_in_the_genome_space_names_the_organism(puppet, monkeypatch, method, wrong, says):
    monkeypatch.setattr(RealSpace, method, wrong)
    with pytest.raises(PluginError, match=f"organism 'puppet'.* {says}"):
        bred(puppet())
