"""Genealogies: the ancestors of the individuals that a search still has.

Individuals without living descendants are dropped as the generations go by, so the memory grows
with the tree of the living rather than with the run.
"""

from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Genomes, GenomeSpace, RealSpace
from gaitsim.plugin.runs import Bred

NONE = -1
"""The row of a parent that does not exist."""
_UNKNOWN = 2**62  # of a genome that is neither in the generation nor in the pool
RESTARTS = "restarts"
"""The figure of searches that begin again, after which no genome has a parent."""
CANDIDATES = 4  # nearest genomes by rounded distances, which are compared exactly
FEWEST = 2_000  # rows before the first pruning

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Rows:
    """Individuals, each once even if it was copied into later generations.

    Attributes:
        genomes: genomes, (rows, genes).
        scores: scores in the generation of birth, (rows,); NaN for centres.
        generation: generation of birth, counted from 1, (rows,).
        number: number in that generation, counted from 1; 0 for its centre, (rows,).
        parent: row of the main parent, or `NONE`, (rows,).
        other: generation and number of the other parent, (rows, 2); 0 for none.
        inherited: whether a gene differs from the main parent's and equals the other's,
            (rows, genes).
        named: whether the search named the parents; otherwise, the parent is the nearest of the
            genomes from which the generation was bred, (rows,).
    """

    genomes: Genomes
    scores: Floats
    generation: Integers
    number: Integers
    parent: Integers
    other: Integers
    inherited: NDArray[np.bool_]
    named: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.scores)

    def take(self, rows: NDArray[Any]) -> Self:
        """Return some of the rows; parents keep their numbers."""
        return type(self)(**{one.name: getattr(self, one.name)[rows] for one in fields(self)})

    @classmethod
    def joined(cls, parts: list["Rows"]) -> "Rows":
        """Return all rows, one part after the other."""
        columns = {one.name: [getattr(part, one.name) for part in parts] for one in fields(cls)}
        return cls(**{name: np.concatenate(found) for name, found in columns.items()})


def line_of(rows: Rows, row: int) -> list[int]:
    """Return an individual and its ancestors by their rows, the first one first."""
    parents, found = rows.parent.tolist(), []
    while row >= 0:
        found.append(row)
        row = parents[row]
    return found[::-1]


class Genealogy:
    """The individuals that a search has, and their ancestors by the main parent.

    The main parent is the one whose genome is nearer; the order of the search decides ties.

    Args:
        space: genome space of the body.

    Attributes:
        latest: rows of the individuals of the last generation, (population,).
        pool: rows of the genomes from which the next generation is bred, (pool,); `NONE` for those
            of unknown origin.
        centre: row of the centre of the last generation, or `NONE`.
    """

    def __init__(self, space: GenomeSpace) -> None:
        self._space = space
        self._parts: list[Rows] = []
        self._size, self._limit = 0, FEWEST
        self.latest = self.pool = np.empty(0, np.int64)
        self._places = np.empty((0, 2), np.int64)  # generation and number of the pool
        self._restarts, self._begins = 0.0, True
        self.centre = NONE

    def add(self, bred: Bred) -> None:
        """Add a generation."""
        generation = bred.generation
        genomes, count = generation.genomes, len(generation.genomes)
        main, other = self._parents(bred)
        has, mated = main >= 0, other >= 0
        same = np.zeros(count, np.bool_)
        same[has] = (genomes[has] == bred.pool[main[has]]).all(axis=1)
        new = np.flatnonzero(~same)
        rows = np.full(count, NONE)
        rows[has] = self.pool[main[has]]  # of copies, and of the parents of others
        if bred.centre is not None:
            self._move_centre(bred.centre, generation.number)
            rows[:] = self.centre
        places = np.zeros((count, 2), np.int64)
        places[mated] = self._places[other[mated]]
        inherited = np.zeros(genomes.shape, np.bool_)
        both = has & mated
        inherited[both] = (genomes[both] != bred.pool[main[both]]) & (
            genomes[both] == bred.pool[other[both]]
        )
        born = Rows(
            genomes,
            generation.scores,
            np.full(count, generation.number),
            1 + np.arange(count),
            rows,
            places,
            inherited,
            np.full(count, bred.parents is not None or bred.centre is not None),
        )
        self._parts.append(born.take(new))
        self.latest = rows.copy()
        self.latest[new] = self._size + np.arange(len(new))
        self._size += len(new)
        here = np.stack([born.generation, born.number], axis=1)
        here[same] = self._places[main[same]]
        self._keep(bred, here)
        restarts = generation.figures.get(RESTARTS, 0.0)
        self._begins, self._restarts = restarts != self._restarts, restarts
        if self._size > self._limit:
            self.prune()
            self._limit = max(FEWEST, 2 * self._size)

    @property
    def rows(self) -> Rows:
        """All individuals that are kept."""
        if len(self._parts) > 1:
            self._parts = [Rows.joined(self._parts)]
        return self._parts[0]

    def row_of(self, genome: NDArray[Any]) -> int | None:
        """Return the row of a genome that the search has; None if it has none like it."""
        living = self.living
        equal = np.flatnonzero((self.rows.genomes[living] == genome).all(axis=1))
        return int(living[equal[0]]) if len(equal) else None

    def prune(self) -> None:
        """Drop individuals without living descendants."""
        rows = self.rows
        kept = np.zeros(len(rows), np.bool_)
        kept[self.living] = True
        for row, parent in zip(
            range(len(rows) - 1, -1, -1), rows.parent[::-1].tolist(), strict=True
        ):
            if parent >= 0 and kept[row]:  # a child follows its parents
                kept[parent] = True
        numbers = np.cumsum(kept) - 1
        numbers = np.append(numbers, NONE)  # row −1
        found = rows.take(kept)
        self._parts = [replace(found, parent=numbers[found.parent])]
        self._size = len(found)
        self.latest, self.pool = numbers[self.latest], numbers[self.pool]
        self.centre = int(numbers[self.centre])

    @property
    def living(self) -> Integers:
        """Rows of the last generation and of the genomes from which the next one is bred."""
        living = np.concatenate([self.latest, self.pool, [self.centre]])
        return living[living >= 0]

    def _move_centre(self, genome: NDArray[Any], generation: int) -> None:
        """Add a centre, whose parent is the one before, except after a restart."""
        parent = NONE if self._begins else self.centre
        if parent >= 0 and np.array_equal(self.rows.genomes[parent], genome):
            return
        self._parts.append(
            Rows(
                genome[None],
                np.array([np.nan]),
                np.array([generation]),
                np.array([0]),
                np.array([parent]),
                np.zeros((1, 2), np.int64),
                np.zeros((1, len(genome)), np.bool_),
                np.array([True]),
            )
        )
        self.centre, self._size = self._size, self._size + 1

    def _keep(self, bred: Bred, here: Integers) -> None:
        """Find the genomes of the next pool in the last generation, or in the pool before."""
        known = {one.tobytes(): at for at, one in enumerate(bred.generation.genomes)}
        known |= {one.tobytes(): ~at for at, one in enumerate(bred.pool)}
        at = np.array([known.get(one.tobytes(), _UNKNOWN) for one in bred.kept], np.int64)
        pool, places = np.full(len(at), NONE), np.zeros((len(at), 2), np.int64)
        new, old = (at >= 0) & (at < _UNKNOWN), at < 0
        pool[new], places[new] = self.latest[at[new]], here[at[new]]
        pool[old], places[old] = self.pool[~at[old]], self._places[~at[old]]
        self.pool, self._places = pool, places

    def _parents(self, bred: Bred) -> tuple[Integers, Integers]:
        """Return the rows of main and other parents in the pool, (population,) each."""
        genomes, pool = bred.generation.genomes, bred.pool
        none = np.full(len(genomes), NONE)
        if bred.centre is not None:
            return none, none
        if bred.parents is None:
            begins = self._begins or not len(pool)
            return none if begins else self._nearest(genomes, pool), none
        main, other = bred.parents.T
        both = (main >= 0) & (other >= 0)
        nearer = np.zeros(len(genomes), np.bool_)
        away = [self._distances(genomes[both], pool[one[both]]) for one in (main, other)]
        nearer[both] = away[1] < away[0]
        nearer |= (main < 0) & (other >= 0)
        main, other = np.where(nearer, other, main), np.where(nearer, main, other)
        return main, np.where(other == main, NONE, other)

    def _shares(self, genomes: Genomes) -> Floats:
        """Return genes on a common scale, (…, genes)."""
        if isinstance(self._space, RealSpace):
            shares: Floats = (genomes - self._space.lower) / self._space.width
            return shares
        return genomes.astype(np.float64)

    def _distances(self, one: Genomes, other: Genomes) -> Floats:
        """Return the sum over the genes of how much two genomes differ, (rows,)."""
        space = self._space
        if not isinstance(space, RealSpace):
            different: Floats = (one != other).sum(axis=-1).astype(np.float64)
            return different
        away = np.abs(self._shares(one) - self._shares(other))
        if space.periodic is not None:
            away = np.where(space.periodic, np.minimum(away, 1 - away), away)
        total: Floats = away.sum(axis=-1)
        return total

    def _nearest(self, genomes: Genomes, pool: Genomes) -> Integers:
        """Return the row of the genome in the pool that is nearest to each genome.

        A product of matrices finds candidates; they are compared exactly, so that the result does
        not depend on the machine.
        """
        one, other = self._shares(genomes), self._shares(pool)
        squares = np.square(other).sum(axis=1) - 2 * one @ other.T
        few = min(CANDIDATES, len(pool))
        near = np.sort(np.argpartition(squares, few - 1, axis=1)[:, :few], axis=1)
        away = np.stack([self._distances(genomes, pool[rows]) for rows in near.T], axis=1)
        found: Integers = near[np.arange(len(genomes)), away.argmin(axis=1)]
        return found
