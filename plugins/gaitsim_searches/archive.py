"""The archive of MAP-Elites: the best genome found in each cell."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Array, Genomes, State

_ROUNDING = 1e-9
"""Tolerance at a border, as a share of a cell: of ten cells between 0 and 1, the value 0.3 belongs
to the fourth, even if rounding makes 0.3 · 10 less than 3."""


@dataclass(frozen=True, eq=False)
class Tessellation:
    """A division of the space of the axes into cells.

    Attributes:
        ranges: low and high end of each axis, (axes, 2).
        counts: number of cells along each axis of a grid, (axes,) int64; empty for Voronoi cells.
        centroids: centre of each Voronoi cell in shares of the axes' ranges, (cells, axes);
            (0, axes) for a grid.
    """

    ranges: NDArray[np.float64]
    counts: NDArray[np.int64]
    centroids: NDArray[np.float64]

    @property
    def total(self) -> int:
        """Number of cells."""
        return int(np.prod(self.counts)) if len(self.counts) else len(self.centroids)

    @property
    def borders(self) -> list[NDArray[np.float64]]:
        """Borders of a grid's cells along each axis; for Voronoi cells, the ends of each axis."""
        counts = self.counts if len(self.counts) else np.ones(len(self.ranges), np.int64)
        return [
            np.linspace(low, high, count + 1)
            for (low, high), count in zip(self.ranges, counts, strict=True)
        ]

    @property
    def centres(self) -> NDArray[np.float64] | None:
        """Centre of each Voronoi cell in the units of the axes, (cells, axes); None for a grid."""
        if len(self.counts):
            return None
        low, high = self.ranges.T
        return np.asarray(low + self.centroids * (high - low))

    def cells(self, values: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the number of the cell of each point, (points, axes) -> (points,) int64.

        Values outside the ranges belong to the outermost cells. A point with a value that is not
        finite belongs to no cell, −1.
        """
        known = np.all(np.isfinite(values), axis=1)
        low, high = self.ranges.T
        shares = (np.clip(np.where(known[:, None], values, low), low, high) - low) / (high - low)
        if len(self.counts):
            steps = np.floor(shares * self.counts + _ROUNDING).astype(np.int64)
            found = np.ravel_multi_index(tuple(np.minimum(steps, self.counts - 1).T), self.counts)
        else:
            _, found = _tree(self.centroids.tobytes(), len(self.ranges)).query(_rounded(shares))
        return np.where(known, found, -1)

    def indices(self, cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the indices of cells along the axes of a grid, or the numbers of Voronoi cells.

        (cells,) -> (cells, axes) for a grid, (cells, 1) for Voronoi cells.
        """
        if not len(self.counts):
            return cells[:, None]
        return np.stack(np.unravel_index(cells, self.counts), 1).astype(np.int64)


@lru_cache(maxsize=4)
def _tree(centroids: bytes, axes: int) -> Any:
    """Return a k-d tree, cached because 10,000 points take longer than a generation."""
    from scipy.spatial import cKDTree  # noqa: TID251 (see `_rounded`); takes 0.2 s

    return cKDTree(_rounded(np.frombuffer(centroids).reshape(-1, axes)))


def _rounded(shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return shares of ranges in whole steps of 2⁻²².

    The sum of 500 squares of their differences is exact, so that the compiled tree finds the same
    centroids on every processor.
    """
    return np.asarray(np.rint(shares * 2.0**22))


def even_centroids(cells: int, axes: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the first points of a scrambled Sobol sequence in the unit cube, (cells, axes).

    Searches find equally good archives with these centroids and with those of Lloyd's algorithm
    (Mouret 2023, "Fast generation of centroids for MAP-Elites"), which takes a minute for 15,625
    cells over eight axes.
    """
    # Whole numbers, scaled by a power of two, are the same everywhere. The import takes 0.5 s.
    from scipy.stats import qmc  # noqa: TID251

    size = (cells - 1).bit_length()  # SciPy warns unless the number is a power of two
    return np.asarray(qmc.Sobol(axes, rng=rng).random_base2(size)[:cells], np.float64)


@dataclass(frozen=True, eq=False)
class Candidates:
    """Evaluated genomes that may enter an archive.

    Attributes:
        cells: cell of each candidate, (candidates,) int64; −1 for none.
        genomes: genomes, (candidates, genes).
        scores: scores, (candidates,); a candidate with −inf cannot enter.
        values: values on the axes, (candidates, axes).
    """

    cells: NDArray[np.int64]
    genomes: Genomes
    scores: NDArray[np.float64]
    values: NDArray[np.float64]

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Whether each candidate can enter an archive at all, (candidates,)."""
        return (self.cells >= 0) & np.isfinite(self.scores)


@dataclass(frozen=True, eq=False)
class Archive:
    """The elites of the occupied cells, in ascending order of the cells.

    Attributes:
        cells: cells, (elites,) int64.
        genomes: genomes, (elites, genes).
        scores: scores, (elites,).
        values: values on the axes, (elites, axes).
        thresholds: score that a candidate must exceed to count as an improvement, (elites,); the
            elite's score except with CMA-MAE.
    """

    cells: NDArray[np.int64]
    genomes: Genomes
    scores: NDArray[np.float64]
    values: NDArray[np.float64]
    thresholds: NDArray[np.float64]

    @classmethod
    def empty(cls, genomes: Genomes, axes: int) -> Self:
        """Return an archive without elites, for genomes with the dtype and genes of `genomes`."""
        none = np.empty(0)
        return cls(np.empty(0, np.int64), genomes[:0], none, np.empty((0, axes)), none)

    @classmethod
    def from_state(cls, state: State) -> Self:
        """Return the archive in a state."""
        return cls(**{field.name: state[field.name] for field in fields(cls)})

    def arrays(self) -> Mapping[str, Array]:
        """Return the arrays of a state by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def is_consistent(self, cells: int, axes: int) -> bool:
        """Return whether the arrays are consistent and fit these numbers of cells and axes."""
        elites = len(self.cells)
        bounds = np.concatenate([[-1], self.cells, [cells]]) if self.cells.ndim == 1 else [0, 0]
        return (
            bool((np.diff(bounds) > 0).all())
            and self.genomes.shape[:1] == self.scores.shape == self.thresholds.shape == (elites,)
            and self.values.shape == (elites, axes)
            and all(np.isfinite(one).all() for one in (self.scores, self.thresholds, self.values))
        )

    def lookup(
        self, cells: NDArray[np.int64], numbers: NDArray[np.float64], otherwise: float
    ) -> NDArray[np.float64]:
        """Look up a number of the elite of each cell, (cells,); `otherwise` if the cell is empty.

        Args:
            cells: cells to look up, (cells,).
            numbers: number of each elite, (elites,).
            otherwise: number for an empty cell.
        """
        if not len(self.cells):
            return np.full(len(cells), otherwise)
        slots = np.minimum(np.searchsorted(self.cells, cells), len(self.cells) - 1)
        return np.where(self.cells[slots] == cells, numbers[slots], otherwise)

    def inserted(self, candidates: Candidates) -> "Archive":
        """Return the archive after the insertion of a batch.

        A candidate enters an empty cell, or a cell whose elite has a lower score. Of several
        candidates for a cell the best enters; ties go to the first. The thresholds of changed
        cells become the scores of their elites.
        """
        better = candidates.scores > self.lookup(candidates.cells, self.scores, -np.inf)
        rows = np.flatnonzero(candidates.valid & better)
        rows = rows[np.lexsort((-candidates.scores[rows], candidates.cells[rows]))]
        cells, firsts = np.unique(candidates.cells[rows], return_index=True)
        if not len(cells):
            return self
        rows = rows[firsts]
        discovered = ~np.isin(cells, self.cells, assume_unique=True)
        gaps = np.searchsorted(self.cells, cells[discovered])
        all_cells = np.insert(self.cells, gaps, cells[discovered])
        slots = np.searchsorted(all_cells, cells)

        def updated(old: Array, new: Array) -> Array:
            array = np.insert(old, gaps, new[discovered], axis=0) if len(gaps) else old.copy()
            array[slots] = new
            return array

        scores = candidates.scores[rows]
        return Archive(
            cells=all_cells,
            genomes=updated(self.genomes, candidates.genomes[rows]),
            scores=updated(self.scores, scores),
            values=updated(self.values, candidates.values[rows]),
            thresholds=updated(self.thresholds, scores),
        )
