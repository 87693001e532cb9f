"""NSGA-II: fronts of known problems, distributions of its operators, and its state."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy import stats

from gaitsim.contracts import BitSpace, RealSpace
from gaitsim.contracts.search import NO_STARTS, Context, Results
from gaitsim_searches.breeding import exchange_segment, polynomial, simulated_binary
from gaitsim_searches.nsga_2 import Nsga2

TWO = {"near": "min", "far": "max"}


def _reals(genes, *, lower=0.0, upper=1.0, periodic=None):
    labels = tuple(map(str, range(genes)))
    return RealSpace(np.full(genes, lower), np.full(genes, upper), labels, periodic=periodic)


def _context(space, generation, purpose, population=20, start=None):
    rng = np.random.default_rng([3, generation, purpose])
    return Context(space, population, generation, rng, NO_STARTS if start is None else start[None])


def _zdt1(genomes):
    """Return the objectives of ZDT1 (Zitzler, Deb and Thiele 2000); the front is f2 = 1 − √f1."""
    first, rest = genomes[:, 0], 1 + 9 * genomes[:, 1:].mean(axis=1)
    return {"near": first, "far": -rest * (1 - np.sqrt(first / rest))}


def _continued(search, space, evaluate, state, generations, **context):
    """Return the states after each of these generations."""
    states = []
    for generation in generations:
        genomes, asked = search.ask(state, None, _context(space, generation, 1, **context))
        assert space.contains(genomes)
        values = evaluate(genomes)
        results = Results(genomes, values.get("score", values["near"]), values)
        state = search.tell(asked, results, _context(space, generation, 2, **context))
        states.append(state)
    return states


def _evolved(search, space, evaluate, generations, **context):
    state = search.initial(_context(space, 0, 0, **context))
    return _continued(search, space, evaluate, state, range(1, generations + 1), **context)


def test_zdt1_is_solved_in_25_000_evaluations():
    # The budget of Deb et al. 2002. Of [0, 1.1]², the true front dominates 0.1 + 2/3 + 0.11.
    search = Nsga2(objectives=TWO, reference={"near": 1.1, "far": -1.1})
    states = _evolved(search, _reals(30), _zdt1, 250, population=100)
    volumes = [search.figures(state)["hypervolume"] for state in states]
    assert volumes[0] == 0
    assert volumes[-1] > 0.985 * (0.21 + 2 / 3)
    assert search.figures(states[-1])["front size"] > 95


def test_members_are_the_front_in_the_order_of_the_first_objective():
    search, space = Nsga2(objectives=TWO), _reals(6)
    members = search.members(_evolved(search, space, _zdt1, 40)[-1])
    values = _zdt1(members.genomes)
    assert list(members.values) == ["near", "far"]
    for name, found in members.values.items():
        np.testing.assert_array_equal(found, values[name])
    assert (np.diff(values["near"]) > 0).all()
    assert (np.diff(values["far"]) > 0).all()  # `far` is maximised, so no member dominates another


def test_all_trade_offs_between_bits_are_found():
    # Leading ones and trailing zeros: at most 20 together, so there are 21 trade-offs.
    space = BitSpace(tuple(map(str, range(20))))

    def evaluate(genomes):
        ones = np.cumprod(genomes, axis=1).sum(axis=1)
        zeros = np.cumprod(1 - genomes[:, ::-1].astype(int), axis=1).sum(axis=1)
        return {"near": -ones.astype(float), "far": zeros.astype(float)}

    search = Nsga2(objectives=TWO)
    members = search.members(_evolved(search, space, evaluate, 80, population=60)[-1])
    assert set(members.values["far"]) == set(range(21))
    np.testing.assert_array_equal(members.values["far"], 20 + members.values["near"])


def test_failed_individuals_are_dominated_by_all_others():
    space = _reals(4)

    def evaluate(genomes):
        values = _zdt1(genomes)
        failed = genomes[:, 1] > 0.3
        values["far"] = np.where(failed, np.nan, values["far"])
        scores = np.where(genomes[:, 2] > 0.9, -np.inf, 0.0)
        return {**values, "score": scores}

    search = Nsga2(objectives=TWO)
    state = _evolved(search, space, evaluate, 15)[-1]
    members = search.members(state)
    assert (members.genomes[:, 1] <= 0.3).all()
    assert (members.genomes[:, 2] <= 0.9).all()
    # If all fail, there are no members, and the search continues.
    nothing = {"near": np.full(20, np.nan), "far": np.zeros(20)}
    state = _evolved(search, space, lambda _: nothing, 3)[-1]
    assert len(search.members(state).genomes) == 0
    assert search.figures(state) == {"hypervolume": 0.0, "front size": 0.0}
    state = _continued(search, space, _zdt1, state, [4])[-1]
    assert np.isfinite(state["reference"]).all()
    assert search.figures(state)["hypervolume"] > 0


def test_scores_can_be_an_objective():
    search = Nsga2(objectives={"score": "max", "far": "min"})
    assert search.reads() == ("far",)
    space = _reals(3)
    values = {"near": np.arange(20.0), "far": np.arange(20.0)}
    members = search.members(_evolved(search, space, lambda _: values, 1)[-1])
    np.testing.assert_array_equal(members.values["score"], members.scores)
    assert len(members.genomes) == 20


def test_a_warm_start_and_its_mutants_are_half_of_the_first_generation():
    space = _reals(10)
    start = np.full(10, 0.25)
    context = _context(space, 1, 1, start=start)
    genomes, _ = Nsga2(objectives=TWO).ask(
        Nsga2(objectives=TWO).initial(_context(space, 0, 0)), None, context
    )
    np.testing.assert_array_equal(genomes[0], start)
    shared = (genomes == start).mean(axis=1)
    assert (shared[:10] > 0.5).all()
    assert (shared[10:] == 0).all()


def test_rescored_survivors_are_sorted_by_their_new_values():
    search, space = Nsga2(objectives=TWO), _reals(5)
    state = _evolved(search, space, _zdt1, 10)[-1]
    genomes = search.remembered(state)
    far = {**_zdt1(genomes), "far": np.arange(20.0)}
    context = _context(space, 10, 3)
    again = search.rescored(state, Results(genomes, np.zeros(20), far), context)
    members = search.members(again)
    assert members.values["far"].max() == 19
    assert len(members.genomes) < 20
    assert set(map(bytes, again["genomes"])) == set(map(bytes, genomes))


def test_invalid_options_populations_and_states():
    with pytest.raises(ValidationError, match="2"):
        Nsga2(objectives={"near": "min"})
    with pytest.raises(ValidationError, match="far"):
        Nsga2(objectives=TWO, reference={"near": 1.0})
    search = Nsga2(objectives=TWO)
    assert "4" in search.objection(_reals(2), 3)
    assert search.objection(_reals(2), 5) == ""
    context = _context(_reals(2), 1, 1)
    other = Nsga2(objectives={"near": "max", "far": "max"}).initial(context)
    assert "near: max" in search.mismatch(other, context)
    state = search.initial(context)
    assert search.mismatch(state, context) == ""
    for name in ("genomes", "scores", "values", "ranks", "crowding", "reference"):
        assert "shape" in search.mismatch({**state, name: np.zeros((3, 1))}, context)


def test_simulated_binary_crossover_spreads_children_as_published():
    # Deb and Agrawal 1995: β has the distribution ½ β^(η+1) up to 1, then 1 − ½ β^−(η+1).
    eta, pairs = 3.0, 4000
    space = _reals(1, periodic=np.array([True]))
    # The parents are 0.2 apart across the bound.
    parents = np.stack([np.full((pairs, 1), 0.9), np.full((pairs, 1), 0.1)])
    rng = np.random.default_rng(5)
    children = simulated_binary(parents, np.ones((pairs, 1), np.bool_), eta, space, rng)
    np.testing.assert_allclose(children.mean(axis=0), 1.0)
    spread = np.abs(children[0] - children[1])[:, 0] / 0.2

    def distribution(beta):
        return np.where(beta <= 1, beta ** (eta + 1) / 2, 1 - beta ** -(eta + 1) / 2)

    assert stats.kstest(spread, distribution).pvalue > 0.01
    assert (children[0] > children[1]).mean() == pytest.approx(0.5, abs=0.04)


def test_crossover_stays_within_the_bounds_and_keeps_genes_that_are_not_crossed():
    space, rng = _reals(6), np.random.default_rng(6)
    parents = rng.random((2, 500, 6))
    parents[:, :, 0] = rng.integers(0, 2, (2, 500))  # parents at the bounds
    crossed = rng.random((500, 6)) < 0.5
    children = simulated_binary(parents, crossed, 0.0, space, rng)
    assert children.min() > -1e-12
    assert children.max() < 1 + 1e-12
    np.testing.assert_array_equal(children[:, ~crossed], parents[:, ~crossed])
    assert (children[:, crossed] != parents[:, crossed]).mean() > 0.9


@pytest.mark.parametrize("periodic", [False, True])
def test_polynomial_mutation_steps_as_published(periodic):
    # Deb and Agrawal 1999: of a step down, (1 + δ)^(η+1) is uniform between its value at the
    # bound and 1; a periodic gene may step a whole width.
    eta, count, place = 20.0, 6000, 0.1
    space = _reals(1, periodic=np.array([periodic]))
    genomes = np.full((count, 1), place)
    rng = np.random.default_rng(7)
    steps = polynomial(genomes, np.ones((count, 1), np.bool_), eta, space, rng)[:, 0] - place
    assert (steps < 0).mean() == pytest.approx(0.5, abs=0.03)
    for side, room in ((-1, place), (1, 1 - place)):
        size = np.abs(steps[np.sign(steps) == side])
        least = 0.0 if periodic else (1 - room) ** (eta + 1)
        uniform = ((1 - size) ** (eta + 1) - least) / (1 - least)
        assert stats.kstest(uniform, "uniform").pvalue > 0.01


def test_bits_are_exchanged_between_two_cuts():
    parents = np.stack([np.zeros((3000, 7), np.uint8), np.ones((3000, 7), np.uint8)])
    crossed = np.arange(3000) < 2000
    children = exchange_segment(parents, crossed, np.random.default_rng(8))
    np.testing.assert_array_equal(children[0], 1 - children[1])
    first = np.pad(children[0], ((0, 0), (1, 1))).astype(int)
    np.testing.assert_array_equal(np.abs(np.diff(first)).sum(axis=1)[crossed], 2)  # one segment
    assert not children[0][~crossed].any()
