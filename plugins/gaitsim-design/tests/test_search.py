"""The search `designs`: its designs, replicates, speed and state."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.contracts import Context, RealSpace, Results
from gaitsim_design.search import Designs, designs_of

LOW, HIGH = np.array([0.7, 0.5]), np.array([1.3, 1.2])
SPACE = RealSpace(np.append([-1.0], LOW), np.append([1.0], HIGH), ("gait", "arm", "leg"))


def search(**options):
    given = {"dimensions": ("arm", "leg"), "sample": 4, "replicates": 2, "original": 0}
    return Designs(**(given | options))


def context(generation, seed=0, starts=((0.5, 1.0, 1.0),)):
    rng = np.random.default_rng([seed, generation])
    return Context(SPACE, 8, generation, rng, starts=np.array(starts))


def advance(one, state, last, generation, score):
    genomes, state = one.ask(state, last, context(generation))
    results = Results(genomes, *score(genomes))
    return one.tell(state, results, context(generation)), results


def test_a_grid_contains_the_original_once_and_both_ends():
    rng = np.random.default_rng(0)
    found = designs_of(LOW, np.array([1.3, 1.5]), 7, 0, rng)
    assert len(found) == 49
    assert (found == 1).all(axis=1).sum() == 1
    np.testing.assert_array_equal(found.min(axis=0), LOW)
    # Between the lines of the grid, the original comes first.
    found = designs_of(LOW, HIGH, 7, 0, rng)
    assert found.shape == (50, 2)
    assert (found[0] == 1).all()


def test_a_sample_has_one_design_in_each_slice_of_each_dimension():
    found = designs_of(LOW, HIGH, 7, 11, np.random.default_rng(0))
    assert (found[0] == 1).all()
    slices = np.sort(np.floor((found[1:] - LOW) / (HIGH - LOW) * 10), axis=0)
    np.testing.assert_array_equal(slices, np.arange(10)[:, None].repeat(2, axis=1))


def test_known_gaits_are_tried_by_all_designs_one_after_another():
    one = search()
    gaits = [(0.1, 1, 1), (0.2, 1, 1), (0.3, 1, 1)]
    state = one.initial(context(1, starts=gaits))
    assert one.transfers(3) == 2
    tried = [one.ask(state, None, context(number))[0] for number in (1, 2)]
    np.testing.assert_allclose(tried[0][:, 0], [0.1] * 4 + [0.2] * 4)
    np.testing.assert_allclose(tried[1][:, 0], [0.3] * 4 + [0.1] * 4)
    np.testing.assert_array_equal(tried[0][:, 1:], np.tile(state["designs"], (2, 1)))


def test_designs_keep_the_better_gait_and_replicates_exchange_none():
    one = search()

    def run(shift):
        def score(genomes):
            scores = -np.abs(genomes[:, 0])
            scores[4:] += shift * np.arange(4)  # the second replicate alone
            return scores, {}

        state, last, bests = one.initial(context(1)), None, []
        for generation in range(1, 20):
            state, last = advance(one, state, last, generation, score)
            bests.append(state["scores"])
        return state, np.array(bests)

    state, bests = run(0.0)
    assert (np.diff(bests, axis=0) >= 0).all()
    assert (bests[-1] > bests[0]).all()
    other, _ = run(-1.0)
    np.testing.assert_array_equal(other["genomes"][:4], state["genomes"][:4])
    assert one.mismatch(state, context(20)) == ""
    assert one.figures(state)["designs"] == 4


def test_a_gait_that_reaches_the_speed_beats_a_faster_or_better_one_that_does_not():
    one = search(speed=1.0)
    scores = np.array([5.0, 1.0, 9.0, -np.inf, 2.0, 0.0, 0.0, 0.0])
    speeds = np.array([0.5, 1.5, 0.4, 2.0, 3.0, 0.1, 0.1, 0.1])
    before = np.array([1.0, 5.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    known = np.array([0.4, 0.9, 0.5, 0.1, 1.5, 0.1, 0.1, 0.1])
    state, last = one.initial(context(1)), None
    for number, pair in enumerate([(before, known), (scores, speeds)], 1):
        state, last = advance(one, state, last, number, lambda genomes, pair=pair: (
            pair[0], {"speed": pair[1]}))  # fmt: skip
    assert state["scores"].tolist() == [5.0, 1.0, 1.0, 1.0, 2.0, 0.0, 0.0, 0.0]
    assert one.best(state).tolist() == [1, 0, 0, 0]


def test_gaits_evolve_on_the_original_and_the_best_of_each_replicate_is_transferred():
    one = search(original=3)
    state, last = one.initial(context(1)), None

    def score(genomes):
        return -np.abs(genomes[:, 0] - 0.5 * genomes[:, 1]), {}

    for generation in (1, 2, 3):
        state, last = advance(one, state, last, generation, score)
        assert (last.genomes[:, 1:] == 1).all()
        assert not one.has_designs(state)
        assert len(one.members(state).scores) == 0
        assert one.mismatch(state, context(generation + 1)) == ""
    leading = state["scores"].reshape(2, 4).argmax(axis=1) + np.array([0, 4])
    gaits = state["genomes"][leading, 0]
    state, last = advance(one, state, last, 4, score)
    np.testing.assert_array_equal(last.genomes[:, 0], gaits.repeat(4))
    np.testing.assert_array_equal(state["genomes"][:4, 1:], state["designs"])
    np.testing.assert_array_equal(state["scores"], score(state["genomes"])[0])


def test_designs_without_a_gait_are_no_members():
    one = search()

    def score(genomes):
        return np.where(genomes[:, 1] > 1, -np.inf, genomes[:, 2]), {}

    state, _ = advance(one, one.initial(context(1)), None, 1, score)
    members = one.members(state)
    kept = state["designs"][:, 0] <= 1
    np.testing.assert_array_equal(members.values["leg"], state["designs"][kept, 1])
    np.testing.assert_array_equal(members.cells[:, 0], np.flatnonzero(kept))
    assert len(one.members(one.initial(context(1))).scores) == 0


def test_objections_name_what_does_not_fit():
    assert search().objection(SPACE, 8) == ""
    assert "must be 10: 5 designs in 2" in search(sample=5).objection(SPACE, 8)
    assert "from 2 to 100,000" in search(sample=1).objection(SPACE, 8)
    assert "too few for 3" in search(dimensions=("a", "b", "c")).objection(SPACE, 8)
    away = replace(SPACE, lower=np.array([-1.0, 1.1, 0.5]))
    assert "must contain the original" in search().objection(away, 8)


@pytest.mark.parametrize("name", ["designs", "genomes", "scores", "known"])
def test_a_state_of_other_designs_is_reported(name):
    one = search()
    state, _ = advance(one, one.initial(context(1)), None, 1, lambda g: (np.zeros(8), {}))
    assert one.mismatch(state, context(2)) == ""
    assert one.mismatch({**state, name: state[name][:-1]}, context(2)) or name == "known"
    assert name == "scores" or one.mismatch({**state, name: state[name] + 7}, context(2))
