"""MAP-Elites as a search: archives, members, invalid states and options, saved states."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.contracts import BitSpace, Context, RealSpace, Results
from gaitsim.contracts.search import NO_STARTS
from gaitsim_searches.map_elites import MapElites

VARIATIONS = ["isotropic", "line", "cma-me", "cma-mae"]
JOINTS = 8
ARM = RealSpace(
    np.full(JOINTS, -np.pi),
    np.full(JOINTS, np.pi),
    tuple(f"joint {joint}" for joint in range(JOINTS)),
    periodic=np.ones(JOINTS, bool),
)
AXES = {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}
BITS = BitSpace(tuple(map(str, range(12))))


def _context(generation, space=ARM, population=42, start=None, stream=0):
    rng = np.random.default_rng([1, generation, stream])
    return Context(space, population, generation, rng, NO_STARTS if start is None else start[None])


def _reach(genomes):
    """Evaluate planar arms: place of the hand and evenness of the bend (Cully and Demiris 2018)."""
    angles = np.cumsum(genomes, 1)
    hand = {"x": np.cos(angles).mean(1), "y": np.sin(angles).mean(1)}
    return Results(genomes, -np.std(genomes, axis=1), hand)


def _count(genomes):
    """Evaluate bits: shares of ones in both halves; the score is that at even places."""
    halves = {"x": genomes[:, :6].mean(1), "y": genomes[:, 6:].mean(1)}
    return Results(genomes, genomes[:, ::2].mean(1), halves)


def _evolve(search, generations, space=ARM, evaluate=_reach, state=None, first=1, **options):
    if state is None:
        state = search.initial(_context(0, space, **options))
    for generation in range(first, first + generations):
        genomes, state = search.ask(state, None, _context(generation, space, stream=1, **options))
        assert space.contains(genomes)
        state = search.tell(state, evaluate(genomes), _context(generation, space, **options))
    return state


@pytest.mark.parametrize("cells", [(20, 20), 300])
@pytest.mark.parametrize("variation", VARIATIONS)
def test_variations_beat_random_genomes(variation, cells):
    options = {"axes": AXES, "cells": cells, "threshold": -4.0, "offset": -4.0, "sigma": 0.05}
    search = MapElites(variation=variation, **options)
    found = search.figures(_evolve(search, 60))
    chance = MapElites(random=60, **options)
    base = chance.figures(_evolve(chance, 60))
    assert found["coverage"] > 1.3 * base["coverage"]
    assert found["QD score"] > 1.5 * base["QD score"]
    assert found["best elite"] > base["best elite"]


@pytest.mark.parametrize("variation", ["isotropic", "line"])
def test_bits_fill_every_cell(variation):
    search = MapElites(axes={"x": (0, 1), "y": (0, 1)}, cells=(7, 7), variation=variation)
    state = _evolve(search, 60, BITS, _count)
    # Each half has 3 even places, so at most 3 of its ones count towards the score.
    assert search.figures(state)["coverage"] == 1
    ones = np.minimum(np.arange(7), 3)
    np.testing.assert_array_equal(state["scores"], ((ones[:, None] + ones) / 6).ravel())


@pytest.mark.parametrize("variation", VARIATIONS)
def test_failed_individuals_and_unknown_values_do_not_enter(variation):
    def failing(genomes):
        results = _reach(genomes)
        scores = np.where(np.arange(len(genomes)) % 2, -np.inf, results.scores)
        x = np.where(np.arange(len(genomes)) % 4 == 2, np.nan, results.values["x"])
        return Results(genomes, scores, {**results.values, "x": x})

    search = MapElites(axes=AXES, cells=(30, 30), variation=variation, threshold=-4.0)
    members = search.members(_evolve(search, 5, evaluate=failing))
    assert len(members.scores) > 10
    assert np.isfinite(members.scores).all()
    assert np.isfinite(members.values["x"]).all()
    none = _evolve(search, 3, evaluate=lambda genomes: replace(
        failing(genomes), scores=np.full(len(genomes), -np.inf)))  # fmt: skip
    assert search.figures(none) == {"coverage": 0, "QD score": 0, "best elite": -np.inf}
    assert len(search.members(none).scores) == 0
    assert len(search.members(_evolve(search, 2, state=none, first=4)).scores) > 10


@pytest.mark.parametrize("variation", VARIATIONS)
def test_half_of_the_first_genomes_are_a_start_point_and_genomes_around_it(variation):
    search = MapElites(axes=AXES, cells=(9, 9), variation=variation, sigma=0.01, step=0.01)
    start = np.linspace(-0.5, 0.5, JOINTS)
    context = _context(1, start=start)
    genomes, _ = search.ask(search.initial(context), None, context)
    np.testing.assert_array_equal(genomes[0], start)
    deviations = (genomes[1:21] - start) / ARM.width
    assert 0.007 < deviations.std() < 0.013
    assert (genomes[21:] - start).std() > 0.1


def test_members_have_the_cells_and_values_of_their_genomes():
    search = MapElites(axes=AXES, cells=(6, 4))
    state = _evolve(search, 10)
    members = search.members(state)
    results = _reach(members.genomes)
    np.testing.assert_array_equal(members.scores, results.scores)
    for axis, (name, count) in enumerate({"x": 6, "y": 4}.items()):
        np.testing.assert_array_equal(members.values[name], results.values[name])
        borders = members.borders[name]
        np.testing.assert_allclose(borders, np.linspace(-1, 1, count + 1))
        np.testing.assert_array_equal(
            members.cells[:, axis], np.digitize(members.values[name], borders[1:-1])
        )
    assert members.cells.tolist() == sorted(members.cells.tolist())
    figures = search.figures(state)
    assert figures["coverage"] == len(members.scores) / 24
    assert figures["QD score"] == pytest.approx(members.scores.sum())
    assert figures["best elite"] == members.scores.max()


@pytest.mark.parametrize("variation", ["line", "cma-mae"])
def test_rescored_elites_move_to_the_cells_of_their_new_values(variation):
    search = MapElites(axes=AXES, cells=(6, 6), variation=variation, threshold=-9.0)
    state = _evolve(search, 8)
    genomes = search.remembered(state)
    squeezed = {"x": 0.2 * _reach(genomes).values["x"], "y": np.zeros(len(genomes))}
    scores = np.arange(len(genomes), dtype=float)
    after = search.rescored(state, Results(genomes, scores, squeezed), _context(9))
    cells = search.members(after).cells
    assert set(map(tuple, cells)) == {(2, 3), (3, 3)}
    for (column, _), score in zip(cells, after["scores"], strict=True):
        assert score == scores[(squeezed["x"] >= 0) == (column == 3)].max()
    assert search.mismatch(after, _context(9)) == ""
    assert (after["thresholds"] <= after["scores"]).all()


def test_a_state_continues_with_another_variation():
    state = _evolve(MapElites(axes=AXES, cells=(8, 8), variation="line"), 5)
    before = len(state["cells"])
    for variation in VARIATIONS:
        search = MapElites(axes=AXES, cells=(8, 8), variation=variation, threshold=-4.0)
        assert search.mismatch(state, _context(6)) == ""
        assert len(_evolve(search, 3, state=state, first=6)["cells"]) >= before


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"axes": {"x": (-1, 1), "z": (-1, 1)}}, "axes"),
        ({"axes": {"y": (-1, 1), "x": (-1, 1)}}, "axes"),
        ({"axes": {"x": (-1, 1), "y": (-1, 2)}}, "ranges"),
        ({"cells": (4, 5)}, "cells"),
        ({"cells": 20}, "cells"),
    ],
)
def test_an_archive_of_other_axes_does_not_fit(options, word):
    options = {"axes": AXES, "cells": (5, 4)} | options
    state = _evolve(MapElites(axes=AXES, cells=(5, 4)), 2)
    assert word in MapElites(**options).mismatch(state, _context(3))


@pytest.mark.parametrize("name", ["cells", "genomes", "scores", "values", "emitters mean"])
def test_a_state_with_inconsistent_arrays_is_refused(name):
    search = MapElites(axes=AXES, cells=(5, 4), variation="cma-me")
    state = _evolve(search, 3)
    assert "inconsistent arrays" in search.mismatch({**state, name: state[name][1:]}, _context(4))
    assert "inconsistent arrays" in search.mismatch(
        {**state, "cells": state["cells"][::-1]}, _context(4)
    )
    assert "inconsistent arrays" in search.mismatch(
        {**state, "cells": state["cells"] + 20}, _context(4)
    )
    assert "genes" in search.mismatch({**state, "genomes": state["genomes"][:, 1:]}, _context(4))
    assert "genes" in search.mismatch({**state, "genomes": state["genomes"] + 9}, _context(4))
    if name not in {"cells", "genomes"}:
        unknown = {**state, name: np.full_like(state[name], np.nan)}
        assert "inconsistent arrays" in search.mismatch(unknown, _context(4))


def test_emitters_are_refused_for_bits_small_populations_and_many_genes():
    emits = MapElites(axes=AXES, variation="cma-me", emitters=10)
    assert emits.objection(ARM, 20) == ""
    assert "20" in emits.objection(ARM, 19)
    assert "bits" in emits.objection(BITS, 100)
    many = tuple(map(str, range(2_000)))
    large = RealSpace(np.zeros(2_000), np.ones(2_000), many)
    assert "MB" in emits.objection(large, 100)
    assert MapElites(axes=AXES).objection(large, 1) == ""
    assert MapElites(axes=AXES).objection(BITS, 1) == ""
