"""Generations bred again from recorded scores equal those that were evolved."""

from functools import partial

import numpy as np
import pytest

from gaitsim.errors import RunError
from gaitsim.evaluation import evaluate
from gaitsim.individual import Numbered, mark_of
from gaitsim.storage.creation import find_individual
from gaitsim.storage.files.folder import ALL_SCORES
from gaitsim.storage.files.scores import pack_block
from gaitsim.storage.replaying import breed_again
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

ARCHIVE = ("search.plugin=map-elites", "search.axes.reach=[-2, 3]", "search.cells=[8]")
SEARCHES = {
    "genetic": (),
    "age-fitness": ("search.plugin=age-fitness",),
    "front": (
        "search.plugin=nsga-2",
        "search.objectives.reach=max",
        "search.objectives.price=max",
    ),
    "lines": ARCHIVE,
    "emitters": (*ARCHIVE, "search.variation=cma-me", "search.emitters=2"),
    "operators": (*ARCHIVE, "search.variation=operators"),
    "differential evolution": ("search.plugin=differential-evolution",),
    "cma-es": ("search.plugin=cma-es",),
    "random": ("search.plugin=random",),
    "islands": ("islands.number=3", "islands.every=2"),
    "worlds": (
        *("search.plugin=age-fitness", "organism.plugin=windy-puppet"),
        *("worlds.cases=[{wind=0.3}, {}]", "worlds.number=2", "worlds.redraw=3"),
    ),
    "constraints": ("constraints.at_most.reach=0.5",),
}
NAMED = {"genetic", "age-fitness", "front", "lines", "operators", "islands", "worlds"}
NAMED |= {"differential evolution", "constraints"}


@pytest.fixture
def recorded(evolved_puppets):
    """Return a function that evolves puppets; it returns the run and its generations."""
    return partial(evolved_puppets, "run", "evolution.population=8", "evolution.generations=9")


@pytest.mark.parametrize("search", SEARCHES)
def test_all_generations_are_bred_again(recorded, search):
    run, evolved = recorded(*SEARCHES[search])
    bred = [*breed_again(run, run.generation)]
    assert len(bred) == len(evolved) == 9
    for one, then in zip(bred, evolved, strict=True):
        now = one.generation
        assert np.array_equal(now.genomes, then.genomes)
        assert np.array_equal(now.scores, then.scores)
        assert now.progress == then.progress
        assert {*now.state} == {*then.state}
        for name, values in then.state.items():
            assert np.array_equal(now.state[name], values, equal_nan=True), name
    named = [one.parents is not None for one in bred]
    assert not named[0]
    assert all(named[1:]) == (search in NAMED)


@pytest.mark.parametrize("search", sorted(NAMED - {"differential evolution", "front", "lines"}))
def test_without_mutation_the_genes_of_children_are_between_those_of_their_parents(
    recorded, search
):
    options = ("mutation.plugin=gaussian", "mutation.rate=0")
    run, _ = recorded(*SEARCHES[search], *options)
    for bred in [*breed_again(run, run.generation)][1:]:
        main, other = bred.parents.T
        other = np.where(other < 0, main, other)
        related = main >= 0
        assert related.sum() >= len(related) - 1  # newcomers of age-fitness have none
        both = np.stack([bred.pool[main], bred.pool[other]])
        children = bred.generation.genomes
        inside = (children >= both.min(axis=0) - 1e-12) & (children <= both.max(axis=0) + 1e-12)
        assert inside[related].all()


def test_without_variation_children_equal_their_elite(recorded):
    run, _ = recorded(*ARCHIVE, "search.variation=isotropic", "search.sigma=0")
    for bred in [*breed_again(run, run.generation)][1:]:
        assert np.array_equal(bred.generation.genomes, bred.pool[bred.parents[:, 0]])
        assert (bred.parents[:, 1] == -1).all()


def test_a_trial_shares_genes_with_its_target(recorded):
    run, _ = recorded(*SEARCHES["differential evolution"])
    for bred in [*breed_again(run, run.generation)][1:]:
        assert np.array_equal(bred.parents[:, 0], np.arange(8))
        assert np.array_equal(bred.pool[bred.parents[:, 0]], bred.pool)


def test_stages_are_bred_again(recorded, here):
    run, _ = recorded("evolution.generations=4")
    evolved = {}
    options = {"fitness.price": 0.4, "evolution.generations": 8}
    with RunWriter.open(run.path, overrides=options) as writer:
        for generation in writer.evolve(partial(evaluate, writer.experiment)):
            evolved[generation.number] = generation
    for bred in breed_again(RunSnapshot(run.path), 8):
        number = bred.generation.number
        if number in evolved:
            assert np.array_equal(bred.generation.genomes, evolved[number].genomes)
            assert np.array_equal(bred.generation.scores, evolved[number].scores)


@pytest.mark.parametrize("search", ["genetic", "lines"])
def test_any_individual_is_found_by_its_number(recorded, search):
    run, evolved = recorded(*SEARCHES[search])
    which = [Numbered(1, 8), Numbered(6, 3), Numbered(6, 1)]
    for one, found in zip(which, run.individuals(which), strict=True):
        then = evolved[one.generation - 1]
        assert np.array_equal(found.genome, then.genomes[one.number - 1])
        assert found.score == then.scores[one.number - 1]
        assert found.terms == then.evaluation.terms_of(one.number - 1)
        assert find_individual(f"{run.path}{mark_of(one)}").score == found.score
    assert run.individual(Numbered(6, 3)).stem == "generation-6-individual-3"


@pytest.mark.parametrize("which", [Numbered(1, 9), Numbered(1, 0), Numbered(10, 1), Numbered(0, 1)])
def test_an_individual_that_does_not_exist_is_an_error(recorded, which):
    run, _ = recorded()
    with pytest.raises(RunError, match=r"no (individual|generation|centre)"):
        run.individual(which)


def test_forged_scores_are_found(recorded):
    run, _ = recorded()
    path = run.path / ALL_SCORES
    lines = [run.scores(number) for number in range(1, 10)]
    data = path.read_bytes()
    worst = lines[3][0].argmin()
    lines[3][0, worst] = lines[3].max() + 1  # becomes an elite of the next generation
    path.write_bytes(b"".join(pack_block(one.astype("<f8").tobytes()) for one in lines))
    with pytest.raises(RunError, match="generation 5 differs from the record when bred again"):
        [*breed_again(RunSnapshot(run.path), 9)]
    path.write_bytes(data[:-1])
    with pytest.raises(RunError, match=r"scores\.bin ends at generation 8"):
        [*breed_again(RunSnapshot(run.path), 9)]
    path.unlink()
    with pytest.raises(RunError, match=r"scores\.bin is missing"):
        [*breed_again(RunSnapshot(run.path), 9)]


def test_a_member_says_which_values_are_not_those_that_were_asked_for(recorded):
    run, _ = recorded(*ARCHIVE)
    reach = run.members.values["reach"].tolist()
    assert run.individual({"reach": reach[0]}).note == ""
    found = run.individual({"reach": reach[0] + 0.5})
    assert found.note.endswith(f", not {reach[0] + 0.5:g}")
    assert found.note in found.title
