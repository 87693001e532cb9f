"""Trees of modules: repaired genomes, grown bodies, and operators."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gaitsim_creatures.modules import load_modules
from gaitsim_creatures.operators import MutateTree, SwapSubtrees, oscillator_genes
from gaitsim_creatures.trees import (
    BRICK,
    CORE,
    HEAD,
    HINGE,
    MODULE,
    PHASE,
    SYMMETRY,
    TWO_PI,
    WIDTH,
    Bodies,
    Symmetry,
    TreeSpace,
)

TABLE = load_modules("revolve2")


def space_of(nodes: int = 12, symmetry: Symmetry = "gene", largest: float = 1.0) -> TreeSpace:
    """Return a space of trees of the default modules."""
    return TreeSpace(nodes, TABLE.shapes, largest, TABLE.reach, (0.2, 1.5), symmetry)


def drawn(space: TreeSpace, count: int = 300, seed: int = 0) -> np.ndarray:
    """Return random genomes."""
    return space.random(count, np.random.default_rng(seed))


def boxes(bodies: Bodies, row: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the middles and half extents of a body's modules."""
    count = bodies.counts[row]
    return bodies.places[row, :count], bodies.halves[row, :count]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 100.0))
def test_any_numbers_are_repaired_to_a_tree(seed: int, scale: float) -> None:
    """The repair of noise is a tree, which it does not change again."""
    space = space_of()
    noise = scale * np.random.default_rng(seed).standard_normal((20, space.genes))
    repaired = space.repair(noise)
    assert space.contains(repaired)
    for row, count in enumerate(space.grow(repaired).counts):
        modules = space.grow(repaired).modules[row, :count]
        assert modules[0, 0] == CORE
        assert (modules[1:, 1] < np.arange(1, count)).all(), "parents come first"
        faces = list(map(tuple, modules[1:, 1:3].tolist()))
        assert len({*faces}) == len(faces), "one module on each face"
        carriers = modules[modules[1:, 1], 0]
        assert TABLE.shapes.faces[carriers, modules[1:, 2]].all()


def test_modules_do_not_overlap_and_fit_in_the_largest_extent() -> None:
    """Boxes of modules overlap at most by the millimetre that counts as touching."""
    space = space_of(20, largest=0.6)
    bodies = space.grow(drawn(space))
    assert bodies.counts.max() > 10
    for row in range(len(bodies.counts)):
        places, halves = boxes(bodies, row)
        low, high = (places - halves).min(axis=0), (places + halves).max(axis=0)
        assert (high - low <= 0.6 + 1e-9).all()
        apart = np.abs(places[:, None] - places) - (halves[:, None] + halves)
        overlap = (apart < -1.001e-3).all(axis=-1)
        np.fill_diagonal(overlap, False)
        parents = bodies.modules[row, 1 : len(places), 1]
        children = np.arange(1, len(places))
        overlap[children, parents] = overlap[parents, children] = False
        assert not overlap.any()


def test_a_symmetric_body_is_its_own_mirror_image() -> None:
    """Each module has an image of its kind at the mirrored place."""
    space = space_of(symmetry="always")
    bodies = space.grow(drawn(space))
    images = 0
    for row, count in enumerate(bodies.counts):
        places, kinds = bodies.places[row, :count], bodies.modules[row, :count, 0]
        for place, kind in zip(places * [1, -1, 1], kinds, strict=True):
            same = np.linalg.norm(places - place, axis=1) < 1e-6
            assert kind in kinds[same]
        images += int(bodies.modules[row, :count, 5].sum())
    assert images > len(bodies.counts)
    without = space_of(symmetry="never")
    assert not without.grow(drawn(without)).modules[..., 5].any()


def test_hinges_are_placed_as_rotations_compose() -> None:
    """Two quarter turns of a path to the left, and a turn about it, as matrices compose."""
    space = space_of(3, "never")
    genome = np.zeros((1, space.genes))
    genome[0, 0] = 1.0
    nodes = genome[0, HEAD:].reshape(-1, WIDTH)
    nodes[:, :4] = [[BRICK, -1, 1, 0], [HINGE, 0, 1, 2], [BRICK, 1, 0, 0]]
    bodies = space.grow(genome)
    core, brick, hinge = TABLE.shapes.sizes[:, 0]
    second = core / 2 + brick / 2
    expected = [
        [0, 0, 0],
        [0, second, 0],
        [-brick / 2 - hinge / 2, second, 0],
        [-brick / 2 - hinge - brick / 2, second, 0],
    ]
    np.testing.assert_allclose(bodies.places[0], expected, atol=1e-12)
    # Twice to the left is backward; turned by 90°, the hinge's axis y points up or down.
    np.testing.assert_allclose(bodies.turns[0, 2][:, 0], [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(np.abs(bodies.turns[0, 2][:, 1]), [0, 0, 1], atol=1e-12)


def test_crossover_swaps_subtrees() -> None:
    """Every module of a child, with its oscillator, comes from one of its parents."""
    space, rng = space_of(), np.random.default_rng(3)
    mothers, fathers = drawn(space, 100, 1), drawn(space, 100, 2)
    children = SwapSubtrees().cross(mothers, fathers, space, rng)
    assert children.shape == (200, space.genes)
    mixed = 0
    for row, child in enumerate(children[:100]):
        sources = []
        for node in child[HEAD:].reshape(-1, WIDTH):
            if node[MODULE] == HINGE:
                own = [node[4:].tolist() in one[HEAD:].reshape(-1, WIDTH)[:, 4:].tolist()
                       for one in (mothers[row], fathers[row])]  # fmt: skip
                assert any(own)
                sources.append(own.index(True))
        mixed += len({*sources}) == 2
    assert mixed > 10
    assert (children[:, SYMMETRY] == np.concatenate([mothers, fathers])[:, SYMMETRY]).all()


def test_mutation_changes_bodies_or_gaits_as_its_options_say() -> None:
    """Without changes of the body, only the genes of oscillators change, and the reverse."""
    space = space_of()
    genomes, rng = drawn(space), np.random.default_rng(0)
    gait = MutateTree(body=0.0, gait=1.0, symmetry=0.0).mutate(genomes, space, rng)
    changed = (gait != genomes).any(axis=0)
    assert changed.any()
    assert not changed[~oscillator_genes(space)].any()
    tree = space.repair(MutateTree(body=1.0, gait=0.0, symmetry=0.0).mutate(genomes, space, rng))
    before, after = space.grow(genomes).counts, space.grow(tree).counts
    assert (after > before).any()
    assert (after < before).any()
    assert (np.abs(after - before) > 1).any(), "subtrees are removed and copied"
    assert (tree[:, 0] == genomes[:, 0]).all(), "the frequency stays"


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_genomes_that_are_not_finite_are_no_trees(value: float) -> None:
    """A genome of another program is checked before it grows."""
    space = space_of()
    genomes = drawn(space, 2)
    assert space.contains(genomes)
    genomes[0, HEAD + PHASE] = value
    assert not space.contains(genomes)
    genomes[0, HEAD + PHASE] = 2 * TWO_PI
    assert not space.contains(genomes)
