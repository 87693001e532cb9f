"""Trees of modules in genomes of fixed length, and the bodies that grow from them.

A genome holds a frequency, a symmetry, and a number of nodes. Each node is a module on a face of an
earlier node or of the core, with the oscillator of its hinge, so that a subtree takes its movement
along.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin import Genomes, GenomeSpace
from gaitsim.plugin.toolkit import uniform

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

CORE, BRICK, HINGE = 0, 1, 2
FACES = ("front", "left", "right", "back", "up", "down")
FRONT, LEFT, RIGHT, BACK, UP, DOWN = range(6)
TURNS = 8
"""Turns of a module about the axis of its parent's face, each 45°."""

HEAD = 2  # genes before the nodes: frequency and symmetry
FREQUENCY, SYMMETRY = 0, 1
FIELDS = ("module", "parent", "face", "turn", "amplitude", "phase", "offset")
MODULE, PARENT, FACE, TURN, AMPLITUDE, PHASE, OFFSET = range(len(FIELDS))
WIDTH = len(FIELDS)
TWO_PI = 2 * np.pi
NONE, IN_PHASE, ANTIPHASE = 0, 1, 2
"""Values of the gene `symmetry`: none, or copies mirrored in phase or half a stride later."""

Symmetry = Literal["gene", "always", "never"]
"""Whether bodies are symmetric: as their genes say, or all or none of them."""

_TOUCH = 1e-3  # m, overlap of two modules that still counts as touching
_PLANE = (
    1e-6  # m, distance from the plane of symmetry within which a module is its own mirror image
)
_HALF = 0.7071067811865476  # sine of 45°
_SIN = np.array([0.0, _HALF, 1.0, _HALF, 0.0, -_HALF, -1.0, -_HALF])
_COS = np.array([1.0, _HALF, 0.0, -_HALF, -1.0, -_HALF, 0.0, _HALF])
# Columns: the axes of a child's frame in that of its parent.
_FACE_AXES = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
        [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
        [[-1, 0, 0], [0, -1, 0], [0, 0, 1]],
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
    ],
    np.float64,
)


@dataclass(frozen=True, eq=False)
class Shapes:
    """The sizes of modules, and their faces.

    Attributes:
        sizes: extents of core, brick and hinge along their axes, (3, 3) m; x points away from the
            parent.
        faces: whether modules can be attached to each face, (3, 6).
        drop: distance of the core's faces below its middle, m.
    """

    sizes: Floats
    faces: NDArray[np.bool_]
    drop: float


@dataclass(frozen=True, eq=False)
class Bodies:
    """The modules of a population's bodies, each a row; parents come before their children.

    Attributes:
        counts: number of modules of each body, with its core, (population,).
        modules: kind, parent, face, turn, node and copy of each module, (population, modules, 6);
            `copy` is 1 for the mirror image of a node.
        places: middle of each module in the frame of the core, (population, modules, 3) m.
        turns: axes of each module as columns, (population, modules, 3, 3).
        halves: half extents of each module along the axes of the core, (population, modules, 3) m.
    """

    counts: Integers
    modules: Integers
    places: Floats
    turns: Floats
    halves: Floats


@dataclass(frozen=True, eq=False, repr=False)
class TreeSpace(GenomeSpace):
    """Genomes of trees of modules, in an array of fixed length.

    Args:
        nodes: largest number of modules besides the core; mirror images count.
        shapes: sizes and faces of the modules.
        largest: largest extent of a body along an axis of its core, m.
        reach: largest angle of a hinge from its middle, rad.
        frequencies: lowest and highest frequency of the oscillators, Hz.
        symmetry: 'gene', or the same value for all bodies.
    """

    nodes: int
    shapes: Shapes
    largest: float
    reach: float
    frequencies: tuple[float, float]
    symmetry: Symmetry = "gene"

    name: ClassVar[str] = "tree"
    dtype: ClassVar[np.dtype[Any]] = np.dtype(np.float64)

    def __post_init__(self) -> None:
        nodes = range(1, self.nodes + 1)
        labels = ("frequency", "symmetry", *(f"{one} {node}" for node in nodes for one in FIELDS))
        object.__setattr__(self, "labels", labels)

    @property
    def limits(self) -> Floats:
        """The lowest and the highest value of each gene, (2, genes)."""
        first = {"gene": NONE, "always": IN_PHASE, "never": NONE}[self.symmetry]
        last = {"gene": ANTIPHASE, "always": ANTIPHASE, "never": NONE}[self.symmetry]
        low = [0, -1, 0, 0, 0.0, 0.0, -self.reach]
        high = [HINGE, self.nodes - 1, 5, TURNS - 1, self.reach, TWO_PI, self.reach]
        lowest = [self.frequencies[0], first, *low * self.nodes]
        return np.array([lowest, [self.frequencies[1], last, *high * self.nodes]], np.float64)

    def random(self, count: int, rng: np.random.Generator) -> Genomes:
        """Return random trees, (count, genes): bodies of all sizes, of right angles."""
        low, high = self.limits
        genomes = uniform(rng, low, high, (count, self.genes))
        nodes = genomes[:, HEAD:].reshape(count, self.nodes, WIDTH)
        shares = rng.random((count, self.nodes, 4))
        sizes = rng.integers(1, self.nodes + 1, (count, 1))
        kinds = np.where(shares[..., 0] < 0.5, BRICK, HINGE)
        nodes[..., MODULE] = np.where(np.arange(self.nodes) < sizes, kinds, 0)
        nodes[..., PARENT] = np.floor(shares[..., 1] * np.arange(1, self.nodes + 1)) - 1
        nodes[..., FACE] = np.floor(shares[..., 2] * len(FACES))
        nodes[..., TURN] = np.where(shares[..., 3] < 0.5, 0, 2)
        nodes[..., OFFSET] /= 2
        if self.symmetry == "gene":
            genomes[:, SYMMETRY] = np.maximum(rng.integers(-1, 3, count), 0)
        return self.repair(genomes)

    def repair(self, genomes: Genomes) -> Genomes:
        """Return trees without modules that have no parent, no face, or no room.

        A module whose face is occupied moves to the next free face.
        """
        return self._grown(genomes)[0]

    def contains(self, genomes: Genomes) -> bool:
        """Return whether all genomes are trees that `repair` does not change."""
        if not (self._has_form(genomes) and np.isfinite(genomes).all()):
            return False
        return bool((self.repair(genomes) == genomes).all())

    def diversity(self, genomes: Genomes) -> float:
        """Return the standard deviation of a gene relative to its range, averaged over genes."""
        low, high = self.limits
        moving = high > low
        found = np.std(genomes[:, moving], axis=0) / (high - low)[moving]
        return float(np.mean(found))

    def grow(self, genomes: Genomes) -> Bodies:
        """Return the bodies that grow from genomes, (population, genes)."""
        return self._grown(genomes)[1]

    def _grown(self, genomes: Genomes) -> tuple[Genomes, Bodies]:
        count, most = len(genomes), self.nodes + 1
        repaired = np.zeros((count, self.genes))
        bodies = Bodies(
            np.zeros(count, np.int64),
            np.zeros((count, most, 6), np.int64),
            np.zeros((count, most, 3)),
            np.zeros((count, most, 3, 3)),
            np.zeros((count, most, 3)),
        )
        shapes = self.shapes
        _grow_all(
            np.ascontiguousarray(genomes, np.float64),
            self.limits,
            (shapes.sizes, shapes.faces, shapes.drop, self.largest),
            (bodies.modules, bodies.places, bodies.turns, bodies.halves),
            repaired,
            bodies.counts,
        )
        return repaired, bodies


@njit(nogil=True, cache=True)
def mirrored_face(face: int) -> int:
    """Return the face on the other side."""
    return LEFT + RIGHT - face if face in (LEFT, RIGHT) else face


@njit(nogil=True, cache=True)
def _place(
    sizes: Floats,
    drop: float,
    modules: Integers,
    places: Floats,
    turns: Floats,
    halves: Floats,
    index: int,
) -> None:
    """Compute the frame of a module from its row and the frame of its parent."""
    kind, parent = modules[index, 0], modules[index, 1]
    face, turn = modules[index, 2], modules[index, 3]
    above = modules[parent, 0]
    # The face's centre in the frame of the parent, whose middle is the origin.
    at = np.zeros(3)
    for axis in range(3):
        at[axis] = _FACE_AXES[face, axis, 0] * sizes[above, axis] / 2
    if above == CORE and face not in (UP, DOWN):
        at[2] -= drop
    for row in range(3):
        places[index, row] = places[parent, row]
        for axis in range(3):
            places[index, row] += turns[parent, row, axis] * at[axis]
    for row in range(3):
        first = second = third = 0.0
        for axis in range(3):
            first += turns[parent, row, axis] * _FACE_AXES[face, axis, 0]
            second += turns[parent, row, axis] * _FACE_AXES[face, axis, 1]
            third += turns[parent, row, axis] * _FACE_AXES[face, axis, 2]
        turns[index, row, 0] = first
        turns[index, row, 1] = _COS[turn] * second + _SIN[turn] * third
        turns[index, row, 2] = _COS[turn] * third - _SIN[turn] * second
        places[index, row] += first * sizes[kind, 0] / 2
    for row in range(3):
        halves[index, row] = 0.0
        for axis in range(3):
            halves[index, row] += abs(turns[index, row, axis]) * sizes[kind, axis] / 2


@njit(nogil=True, cache=True)
def _has_room(places: Floats, halves: Floats, index: int, parent: int, largest: float) -> bool:
    """Return whether a module overlaps no other and the body stays within its largest extent."""
    for other in range(index):
        if other == parent:
            continue
        apart = False
        for axis in range(3):
            room = halves[index, axis] + halves[other, axis] - _TOUCH
            apart |= abs(places[index, axis] - places[other, axis]) >= room
        if not apart:
            return False
    for axis in range(3):
        low = places[index, axis] - halves[index, axis]
        high = places[index, axis] + halves[index, axis]
        for other in range(index):
            low = min(low, places[other, axis] - halves[other, axis])
            high = max(high, places[other, axis] + halves[other, axis])
        if high - low > largest:
            return False
    return True


@njit(nogil=True, cache=True)
def _add(
    row: Integers,
    index: int,
    shapes: tuple[Floats, NDArray[np.bool_], float, float],
    body: tuple[Integers, Floats, Floats, Floats],
    taken: NDArray[np.bool_],
) -> bool:
    """Place a module in the row `index` of a body; return whether it has a free face and room."""
    sizes, faces, drop, largest = shapes
    modules, places, turns, halves = body
    parent, face = row[1], row[2]
    if index >= len(modules) or taken[parent, face] or not faces[modules[parent, 0], face]:
        return False
    modules[index] = row
    _place(sizes, drop, modules, places, turns, halves, index)
    return _has_room(places, halves, index, parent, largest)


@njit(nogil=True, cache=True)
def _write(node: Floats, row: Integers, parent: int, wanted: Floats, limits: Floats) -> None:
    """Write a node that has grown, with valid genes, (7,), given those wanted and all limits."""
    node[MODULE], node[PARENT], node[FACE], node[TURN] = row[0], parent, row[2], row[3]
    if row[0] != HINGE:
        return
    for field in (AMPLITUDE, OFFSET):
        low, high = limits[0, HEAD + field], limits[1, HEAD + field]
        node[field] = min(max(wanted[field], low), high)
    phase = wanted[PHASE]
    if phase < 0 or phase >= TWO_PI:
        phase -= TWO_PI * np.floor(phase / TWO_PI)
        phase = phase if phase < TWO_PI else 0.0
    node[PHASE] = phase


@njit(nogil=True, cache=True)
def _grow(
    genome: Floats,
    limits: Floats,
    shapes: tuple[Floats, NDArray[np.bool_], float, float],
    body: tuple[Integers, Floats, Floats, Floats],
    clean: Floats,
) -> int:
    """Grow a body, and write its genome without nodes that do not grow.

    Returns:
        The number of modules.
    """
    modules, places, turns, halves = body
    for gene in range(HEAD):
        clean[gene] = min(max(genome[gene], limits[0, gene]), limits[1, gene])
    clean[SYMMETRY] = np.rint(clean[SYMMETRY])
    for axis in range(3):
        turns[0, axis, axis] = 1.0
        halves[0, axis] = shapes[0][CORE, axis] / 2
    modules[0, 1] = modules[0, 4] = -1
    nodes = (len(genome) - HEAD) // WIDTH
    taken = np.zeros((nodes + 1, 6), np.bool_)
    own = np.full(nodes, -1, np.int64)  # row of each node's module
    twin = np.full(nodes, -1, np.int64)  # row of its mirror image
    slot = np.full(nodes, -1, np.int64)  # number of the node in the repaired genome
    count, written = 1, 0
    row, image = np.zeros(6, np.int64), np.zeros(6, np.int64)
    for node in range(nodes):
        wanted = genome[HEAD + node * WIDTH : HEAD + (node + 1) * WIDTH]
        kind, parent = int(np.rint(wanted[MODULE])), int(np.rint(wanted[PARENT]))
        if kind < BRICK or kind > HINGE or parent < -1 or parent >= node:
            continue
        carrier, holder = (0, -1) if parent < 0 else (own[parent], twin[parent])
        if carrier < 0:
            continue
        first = min(max(int(np.rint(wanted[FACE])), 0), 5)
        row[0], row[1], row[4], row[5] = kind, carrier, written, 0
        row[3] = int(np.rint(wanted[TURN])) % TURNS
        for step in range(6):
            row[2] = (first + step) % 6
            if not _add(row, count, shapes, body, taken):
                continue
            taken[carrier, row[2]] = True
            single = holder < 0 and abs(places[count, 1]) < _PLANE
            if clean[SYMMETRY] > 0 and not single:
                image[:] = row
                image[1] = holder if holder >= 0 else carrier
                image[2], image[3] = mirrored_face(row[2]), (TURNS - row[3]) % TURNS
                image[5] = 1
                if not _add(image, count + 1, shapes, body, taken):
                    taken[carrier, row[2]] = False
                    continue
                taken[image[1], image[2]] = True
                twin[node] = count + 1
            own[node], slot[node] = count, written
            count += 1 if twin[node] < 0 else 2
            target = clean[HEAD + written * WIDTH : HEAD + (written + 1) * WIDTH]
            _write(target, row, slot[parent] if parent >= 0 else -1, wanted, limits)
            written += 1
            break
    for unused in range(count, nodes + 1):
        modules[unused] = 0
        places[unused] = 0.0
        turns[unused] = 0.0
        halves[unused] = 0.0
    return count


@njit(nogil=True, cache=True)
def _grow_all(
    genomes: Floats,
    limits: Floats,
    shapes: tuple[Floats, NDArray[np.bool_], float, float],
    bodies: tuple[Integers, Floats, Floats, Floats],
    repaired: Floats,
    counts: Integers,
) -> None:
    """Grow the bodies of a population, and write its repaired genomes."""
    modules, places, turns, halves = bodies
    for one in range(len(genomes)):
        body = (modules[one], places[one], turns[one], halves[one])
        counts[one] = _grow(genomes[one], limits, shapes, body, repaired[one])
