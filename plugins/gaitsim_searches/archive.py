"""The archive of MAP-Elites: the best genome found in each cell."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, Genomes, State


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
