"""The contract of operators, for all that are installed with gaitsim."""

from importlib.metadata import EntryPoint, distribution

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gaitsim.contracts import BitSpace, Crossover, GenomeSpace, Mutation, RealSpace, Selection
from gaitsim.errors import PluginError
from gaitsim_operators.mutation import NoMutation

KINDS = {"selection": Selection, "crossover": Crossover, "mutation": Mutation}
REALS = st.floats(-1e6, 1e6)


def _entry_points(kind: str) -> list[EntryPoint]:
    found = [
        entry for entry in distribution("gaitsim").entry_points if entry.group == f"gaitsim.{kind}"
    ]
    return sorted(found, key=lambda entry: entry.name)


def _parameters(kind: str, only: type[GenomeSpace] | None = None) -> list:
    loaded = [(entry.name, entry.load()) for entry in _entry_points(kind)]
    return [
        pytest.param(operator, id=name)
        for name, operator in loaded
        if only is None or operator.spaces == (only,)
    ]


def _labels(genes: int) -> tuple[str, ...]:
    return tuple(f"gene {i}" for i in range(genes))


def _real_space(genes: int, seed: int, *, cyclic: bool, gaussian: bool) -> RealSpace:
    rng = np.random.default_rng(seed)
    lower = rng.uniform(-10, 10, genes)
    width = rng.uniform(0.01, 20, genes)
    return RealSpace(
        lower,
        lower + width,
        _labels(genes),
        initial_sigma=width / 3 if gaussian else None,
        periodic=rng.random(genes) < 0.5 if cyclic else None,
    )


def _at_most_half_set(genomes):
    """Repair genomes with more than half of their bits set: clear the last half."""
    repaired = genomes.copy()
    full = genomes.sum(axis=1) > genomes.shape[1] / 2
    repaired[full, genomes.shape[1] // 2 :] = 0
    return repaired


@st.composite
def spaces(draw, kinds: tuple[type[GenomeSpace], ...]) -> GenomeSpace:
    genes = draw(st.integers(1, 12))
    if draw(st.sampled_from(kinds)) is BitSpace:
        return BitSpace(_labels(genes), draw(st.sampled_from([None, _at_most_half_set])))
    return _real_space(
        genes, draw(st.integers(0, 99)), cyclic=draw(st.booleans()), gaussian=draw(st.booleans())
    )


@st.composite
def all_scores(draw) -> np.ndarray:
    score = st.one_of(st.just(-np.inf), st.sampled_from([0.0, 1.0]), REALS)
    return np.array(draw(st.lists(score, min_size=1, max_size=40)))


@pytest.mark.parametrize(("kind", "count"), [("selection", 6), ("crossover", 6), ("mutation", 6)])
def test_operators_are_found_and_have_default_options(kind, count):
    entries = [entry for entry in _entry_points(kind) if "gaitsim_operators" in entry.value]
    assert len(entries) == count
    for entry in entries:
        assert isinstance(entry.load()(), KINDS[kind])


@pytest.mark.parametrize("kind", KINDS)
def test_every_option_has_a_description(kind):
    for entry in _entry_points(kind):
        for name, field in entry.load().model_fields.items():
            assert field.description, f"{entry.name}.{name}"
            assert not field.is_required(), f"{entry.name}.{name}"


@pytest.mark.parametrize("operator", _parameters("selection"))
@settings(max_examples=60)
@given(scores=all_scores(), pairs=st.integers(0, 60), seed=st.integers(0, 2**32))
def test_selection_returns_pairs_of_indices(operator, scores, pairs, seed):
    before = scores.copy()
    scores.setflags(write=False)
    parents = operator().parents(scores, pairs, np.random.default_rng(seed))
    again = operator().parents(scores, pairs, np.random.default_rng(seed))
    assert parents.shape == (pairs, 2)
    assert parents.dtype == np.intp
    assert ((parents >= 0) & (parents < len(scores))).all()
    np.testing.assert_array_equal(parents, again)
    np.testing.assert_array_equal(scores, before)


@pytest.mark.parametrize("operator", _parameters("selection"))
@pytest.mark.parametrize(
    "scores",
    [[0.0], [-np.inf], [1.0, 2.0], [-np.inf, -np.inf], [3.0] * 9, [-np.inf] * 8 + [5.0]],
    ids=str,
)
def test_selection_accepts_extreme_scores(operator, scores):
    parents = operator().parents(np.array(scores), 40, np.random.default_rng(1))
    assert set(parents.ravel()) <= set(range(len(scores)))


@pytest.mark.parametrize("operator", _parameters("selection"))
def test_selection_favours_the_better(operator):
    scores = np.random.default_rng(3).permutation(60).astype(float)
    parents = operator().parents(scores, 4000, np.random.default_rng(4))
    assert scores[parents].mean() > scores.mean() + 0.4
    assert np.bincount(parents.ravel(), minlength=60)[scores.argmin()] < 8000 / 60


@pytest.mark.parametrize("children", [1, 2])
@pytest.mark.parametrize("operator", _parameters("crossover"))
@settings(max_examples=50)
@given(data=st.data(), pairs=st.integers(0, 9), seed=st.integers(0, 2**32))
def test_crossover_returns_children(operator, children, data, pairs, seed):
    crossover = operator(children=children)
    space = data.draw(spaces(crossover.spaces))
    mothers = space.random(pairs, np.random.default_rng(seed + 1))
    fathers = space.random(pairs, np.random.default_rng(seed + 2))
    before = mothers.copy(), fathers.copy()
    offspring = crossover.cross(mothers, fathers, space, np.random.default_rng(seed))
    again = crossover.cross(mothers, fathers, space, np.random.default_rng(seed))
    assert offspring.shape == (pairs * children, space.genes)
    assert offspring.dtype == space.dtype
    assert np.isfinite(offspring).all()
    assert space.contains(space.repair(offspring))
    np.testing.assert_array_equal(offspring, again)
    # The result is a new array: writing to it changes neither parent.
    offspring[...] = 0
    np.testing.assert_array_equal(mothers, before[0])
    np.testing.assert_array_equal(fathers, before[1])


@pytest.mark.parametrize("operator", _parameters("crossover"))
@settings(max_examples=30)
@given(data=st.data(), seed=st.integers(0, 2**32))
def test_children_of_equal_parents_are_those_parents(operator, data, seed):
    crossover = operator()
    space = data.draw(spaces(crossover.spaces))
    parents = space.random(5, np.random.default_rng(seed))
    offspring = crossover.cross(parents, parents, space, np.random.default_rng(seed))
    np.testing.assert_array_equal(offspring, np.tile(parents, (crossover.children, 1)))


@pytest.mark.parametrize("operator", _parameters("mutation"))
@settings(max_examples=60)
@given(
    data=st.data(),
    population=st.integers(0, 20),
    generation=st.integers(0, 10_000),
    seed=st.integers(0, 2**32),
)
def test_mutation_returns_mutants(operator, data, population, generation, seed):
    mutation = operator().at(generation)
    space = data.draw(spaces(mutation.spaces))
    genomes = space.random(population, np.random.default_rng(seed + 1))
    before = genomes.copy()
    mutants = mutation.mutate(genomes, space, np.random.default_rng(seed))
    again = mutation.mutate(genomes, space, np.random.default_rng(seed))
    assert mutants.shape == genomes.shape
    assert mutants.dtype == space.dtype
    assert np.isfinite(mutants).all()
    assert space.contains(space.repair(mutants))
    np.testing.assert_array_equal(mutants, again)
    mutants[...] = 0
    np.testing.assert_array_equal(genomes, before)


@pytest.mark.parametrize("operator", _parameters("mutation"))
def test_mutation_accepts_genomes_that_are_not_contiguous(operator):
    mutation = operator()
    space = (
        _real_space(6, 0, cyclic=True, gaussian=False)
        if RealSpace in mutation.spaces
        else BitSpace(_labels(6))
    )
    genomes = space.random(50, np.random.default_rng(1))
    plain = mutation.mutate(genomes, space, np.random.default_rng(2))
    turned = mutation.mutate(np.asfortranarray(genomes), space, np.random.default_rng(2))
    assert (plain != genomes).any() or operator is NoMutation
    np.testing.assert_array_equal(plain, turned)


@pytest.mark.parametrize("operator", _parameters("crossover", only=RealSpace))
def test_crossovers_of_real_numbers_refuse_bits(operator):
    space = BitSpace(_labels(3))
    genomes = space.random(4, np.random.default_rng(0))
    with pytest.raises(PluginError, match="genomes of the kind 'bit'"):
        operator().cross(genomes, genomes, space, np.random.default_rng(0))


@pytest.mark.parametrize("operator", _parameters("mutation", only=RealSpace))
def test_mutations_of_real_numbers_refuse_bits(operator):
    space = BitSpace(_labels(3))
    genomes = space.random(4, np.random.default_rng(0))
    with pytest.raises(PluginError, match="genomes of the kind 'bit'"):
        operator().mutate(genomes, space, np.random.default_rng(0))
