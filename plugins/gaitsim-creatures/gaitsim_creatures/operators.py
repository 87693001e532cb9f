"""Crossover and mutation of trees: subtrees are swapped, grown, pruned, changed and duplicated."""

from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin import Crossover, Genomes, GenomeSpace, Mutation, option
from gaitsim.plugin.toolkit import standard_normal
from gaitsim_creatures.trees import (
    AMPLITUDE,
    ANTIPHASE,
    BRICK,
    FACE,
    FACES,
    HEAD,
    HINGE,
    MODULE,
    OFFSET,
    PARENT,
    PHASE,
    SYMMETRY,
    TURN,
    TURNS,
    TWO_PI,
    WIDTH,
    Floats,
    TreeSpace,
    mirrored_face,
)


def tree_space(space: GenomeSpace) -> TreeSpace:
    """Return the space with the type `TreeSpace`, the only one that these operators support."""
    assert isinstance(space, TreeSpace)
    return space


class SwapSubtrees(Crossover):
    """Replaces a random subtree of the mother with a random subtree of the father.

    Koza 1992, "Genetic programming", for bodies as in Sims 1994, "Evolving virtual creatures". A
    subtree takes its movement along. Frequency and symmetry come from the mother.
    """

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (TreeSpace,)

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes), of parents, (pairs, genes) each.

        A second child is bred with the parents exchanged. Nodes beyond the length of a genome are
        dropped.
        """
        children = []
        for one, other in ((mothers, fathers), (fathers, mothers))[: self.children]:
            child = one.copy()
            _swap(one, other, rng.random((len(one), 2)), child)
            children.append(child)
        return np.concatenate(children)


class MutateTree(Mutation):
    """Changes oscillators by small amounts, and sometimes one part of the tree.

    The changes of the tree are equally likely: a new module, a subtree less, another kind, place or
    turn of a module, a copy of a subtree elsewhere, and its mirror image on the opposite face.
    """

    body: float = option(
        0.5, "probability that the tree of a child changes, at one place", ge=0, le=1
    )
    gait: float = option(0.5, "probability that the oscillators of a child change", ge=0, le=1)
    gene: float = option(
        0.3, "probability that each gene of changing oscillators changes", ge=0, le=1
    )
    sigma: float = option(
        0.1, "standard deviation of such a change, as a share of the gene's range", gt=0, le=10
    )
    symmetry: float = option(0.05, "probability that the symmetry is redrawn", ge=0, le=1)

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (TreeSpace,)

    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return mutants, (population, genes), which must be repaired."""
        count, (low, high) = len(genomes), tree_space(space).limits
        found = genomes.copy()
        moving = rng.random((count, 1)) < self.gait
        moving = moving & (rng.random(genomes.shape) < self.gene) & oscillator_genes(space)
        steps = self.sigma * (high - low) * standard_normal(rng, genomes.shape)
        found[moving] += steps[moving]
        drawn = rng.random(count) < self.symmetry
        symmetries = rng.integers(0, ANTIPHASE + 1, count)
        found[drawn, SYMMETRY] = symmetries[drawn]
        chosen = np.flatnonzero(rng.random(count) < self.body)
        changed = np.ascontiguousarray(found[chosen])
        _change_trees(changed, rng.random((len(chosen), 12)), low, high)
        found[chosen] = changed
        return found


def oscillator_genes(space: GenomeSpace) -> NDArray[np.bool_]:
    """Return whether each gene belongs to the movement, not to the body, (genes,)."""
    found = np.zeros(space.genes, np.bool_)
    found[0] = True
    nodes = found[HEAD:].reshape(-1, WIDTH)
    nodes[:, [AMPLITUDE, PHASE, OFFSET]] = True
    return found


@njit(nogil=True, cache=True)
def _size(genome: Floats) -> int:
    """Return the number of nodes before the first empty one."""
    nodes = (len(genome) - HEAD) // WIDTH
    for node in range(nodes):
        if genome[HEAD + node * WIDTH + MODULE] < BRICK:
            return node
    return nodes


@njit(nogil=True, cache=True)
def _below(genome: Floats, root: int) -> NDArray[np.bool_]:
    """Return whether each node is in the subtree of a node, (nodes,)."""
    nodes = _size(genome)
    found = np.zeros(nodes, np.bool_)
    found[root] = True
    for node in range(root + 1, nodes):
        parent = int(genome[HEAD + node * WIDTH + PARENT])
        found[node] = parent >= 0 and found[parent]
    return found


@njit(nogil=True, cache=True)
def _append(
    genome: Floats, used: int, source: Floats, root: int, parent: int, face: int, image: bool
) -> int:
    """Append the subtree of a node, or its mirror image, as far as there is room.

    Returns:
        The number of nodes after it.
    """
    nodes = (len(genome) - HEAD) // WIDTH
    inside = _below(source, root)
    at = np.full(nodes, -1, np.int64)
    for node in range(root, len(inside)):
        if not inside[node] or used >= nodes:
            continue
        start, target = HEAD + node * WIDTH, HEAD + used * WIDTH
        carrier = parent if node == root else at[int(source[start + PARENT])]
        if node != root and carrier < 0:
            continue
        for field in range(WIDTH):
            genome[target + field] = source[start + field]
        genome[target + PARENT] = carrier
        if image:
            genome[target + FACE] = mirrored_face(int(source[start + FACE]))
            genome[target + TURN] = (TURNS - int(source[start + TURN])) % TURNS
        if node == root:
            genome[target + FACE] = face
        at[node] = used
        used += 1
    return used


@njit(nogil=True, cache=True)
def _without(genome: Floats, root: int) -> int:
    """Remove a subtree and close the gaps; return the number of nodes that remain."""
    inside, used = _below(genome, root), 0
    at = np.full(len(inside), -1, np.int64)
    for node in range(len(inside)):
        start, target = HEAD + node * WIDTH, HEAD + used * WIDTH
        if inside[node]:
            continue
        parent = int(genome[start + PARENT])
        for field in range(WIDTH):
            genome[target + field] = genome[start + field]
        genome[target + PARENT] = at[parent] if parent >= 0 else -1
        at[node] = used
        used += 1
    genome[HEAD + used * WIDTH :] = 0.0
    return used


@njit(nogil=True, cache=True)
def _swap(mothers: Floats, fathers: Floats, draws: Floats, children: Floats) -> None:
    for pair in range(len(children)):
        child, father = children[pair], fathers[pair]
        mine, theirs = _size(child), _size(father)
        if not theirs:
            continue
        graft = int(draws[pair, 1] * theirs)
        parent, face = -1, int(father[HEAD + graft * WIDTH + FACE])
        used = 0
        if mine:
            root = int(draws[pair, 0] * mine)
            start = HEAD + root * WIDTH
            # Nodes before the root keep their numbers, and its parent is one of them.
            parent, face = int(child[start + PARENT]), int(child[start + FACE])
            used = _without(child, root)
        _append(child, used, father, graft, parent, face, False)


@njit(nogil=True, cache=True)
def _sprout(genome: Floats, used: int, draw: Floats, low: Floats, high: Floats) -> None:
    """Append a random module, if there is room."""
    start = HEAD + used * WIDTH
    if start == len(genome):
        return
    genome[start + MODULE] = BRICK if draw[5] < 0.5 else HINGE
    genome[start + PARENT] = int(draw[2] * (used + 1)) - 1
    genome[start + FACE], genome[start + TURN] = int(draw[3] * len(FACES)), 2 * int(draw[4] * 2)
    for number, field in enumerate((AMPLITUDE, PHASE, OFFSET)):
        first, last = low[start + field], high[start + field]
        genome[start + field] = first + draw[6 + number] * (last - first)


@njit(nogil=True, cache=True)
def _alter(genome: Floats, start: int, draw: Floats) -> None:
    """Change the kind, the face or the turn of the node whose genes begin at `start`."""
    what = int(draw[6] * 3)
    if what == 0:
        genome[start + MODULE] = BRICK + HINGE - genome[start + MODULE]
    elif what == 1:
        genome[start + FACE] = int(draw[3] * len(FACES))
    else:
        genome[start + TURN] = (int(genome[start + TURN]) + 2) % TURNS


@njit(nogil=True, cache=True)
def _duplicate(genome: Floats, used: int, node: int, draw: Floats, image: bool) -> None:
    """Append a copy of a subtree at a random place, or its mirror image on the opposite face."""
    start = HEAD + node * WIDTH
    parent, face = int(draw[2] * (used + 1)) - 1, int(draw[3] * len(FACES))
    if image:
        parent, face = int(genome[start + PARENT]), mirrored_face(int(genome[start + FACE]))
    after = _append(genome, used, genome.copy(), node, parent, face, image)
    if image and draw[6] < 0.5:  # half a stride later
        for new in range(used, after):
            place = HEAD + new * WIDTH + PHASE
            genome[place] = (genome[place] + TWO_PI / 2) % TWO_PI


@njit(nogil=True, cache=True)
def _change_trees(genomes: Floats, draws: Floats, low: Floats, high: Floats) -> None:
    for individual in range(len(genomes)):
        genome, draw = genomes[individual], draws[individual]
        used = _size(genome)
        change, node = (int(draw[0] * 5) if used else 0), int(draw[1] * used)
        if change == 0:
            _sprout(genome, used, draw, low, high)
        elif change == 1:
            _without(genome, node)
        elif change == 2:
            _alter(genome, HEAD + node * WIDTH, draw)
        else:
            _duplicate(genome, used, node, draw, change == 4)
