"""An archive seen along a few of its axes: the best elite in each cell of a panel."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Members
from gaitsim.render.ticks import round_step

EMPTY = -1  # in place of a member's number
_FEW = 0.1  # share of the cells of a map that may have the darkest colour, as they are far below
MOST = 60  # parts of an axis in a panel, unless the caller says otherwise
_MANY = 4_000  # Voronoi cells
_ROUNDING = 1e-9  # share of an axis: values on a border are above it
_ALL_PAIRS = 4  # axes: six pairs


@dataclass(frozen=True, eq=False)
class Panel:
    """The best elites in the cells of some axes, over all other axes.

    Attributes:
        names: of the axes, one or two.
        borders: of the cells along each axis, ascending, (cells + 1,) each.
        scores: best score in each cell, with an axis for each name; NaN in empty cells.
        members: number of the member with that score, from 1, int64; `EMPTY` in empty cells.
    """

    names: tuple[str, ...]
    borders: tuple[NDArray[np.float64], ...]
    scores: NDArray[np.float64]
    members: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ArchiveView:
    """An archive whose members have cells.

    Attributes:
        members: the elites.
        cells: index of each one's cell, as `Members.cells`.
        borders: of the cells along each axis, by its name, as `Members.borders`.
    """

    members: Members
    cells: NDArray[np.int64]
    borders: dict[str, NDArray[np.float64]]

    @classmethod
    def of(cls, members: Members | None) -> "ArchiveView | None":
        """Return the view of an archive; None where members have no cells, as those of a front."""
        if members is None or members.cells is None or members.borders is None:
            return None
        return cls(members, members.cells, dict(members.borders))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the axes."""
        return tuple(self.borders)

    @property
    def total(self) -> int:
        """Number of cells, empty ones too."""
        centroids = self.members.centroids
        if centroids is not None:
            return len(centroids)
        return int(np.prod([len(borders) - 1 for borders in self.borders.values()]))

    @property
    def filled(self) -> str:
        """How many cells are occupied, in words."""
        count = len(self.members.scores)
        return f"{count:,} of {self.total:,} cells ({count / self.total:.1%})"

    @property
    def best(self) -> int | None:
        """Number of the member with the highest score, from 1; None for an empty archive."""
        scores = self.members.scores
        return int(np.argmax(scores)) + 1 if len(scores) else None

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """The pairs of axes, those to show first in front.

        Of more than four axes, an axis of the first half is paired with one of the second, which
        is the opposite leg where legs are named L1, L2 … R1, R2 …; the other pairs follow.
        """
        names, half = self.names, (len(self.names) + 1) // 2
        pairs = tuple(combinations(names, 2))
        if len(names) <= _ALL_PAIRS:
            return pairs
        opposite = tuple(zip(names[:half], names[half:], strict=False))
        return opposite + tuple(pair for pair in pairs if pair not in opposite)

    def panel(self, *names: str, most: tuple[int, ...] = (MOST, MOST)) -> Panel:
        """Return the best elites along one or two axes, over all others.

        A grid keeps its cells; where they are more than `most`, equal numbers of neighbours are
        one. Axes of a tessellation are divided into equal parts. Where it has no further axis, each
        part shows the Voronoi cell around its middle; otherwise, the best elite within.

        Args:
            names: one axis or two.
            most: cells along each.
        """
        borders = tuple(self.parts(name, count) for name, count in zip(names, most, strict=False))
        shape = tuple(len(one) - 1 for one in borders)
        if self.members.centroids is not None and len(names) == len(self.names):
            numbers = self._around_middles(names, borders)
        else:
            numbers = self._best_within(names, borders, shape)
        scores = np.full(shape, np.nan)
        known = numbers != EMPTY
        scores[known] = self.members.scores[numbers[known] - 1]
        return Panel(names, borders, scores, numbers)

    def parts(self, name: str, most: int = MOST) -> NDArray[np.float64]:
        """Return the borders between the parts of an axis in a panel, (parts + 1,)."""
        borders = self.borders[name]
        if self.members.centroids is None:
            together = -(-(len(borders) - 1) // most)
            inner = borders[:-1:together]
            return np.append(inner, borders[-1])
        if len(self.names) <= 2:
            parts = max(8, round(1.5 * self.total ** (1 / len(self.names))))
        else:
            # Parts of a round width: duty factors of strides of 20 frames are multiples of 1/20,
            # and narrower parts would leave empty stripes between them.
            span = borders[-1] - borders[0]
            parts = max(1, round(span / round_step(span / (20 if self.total >= _MANY else 10))))
        while parts > most:
            parts = -(-parts // 2)
        return np.linspace(borders[0], borders[-1], parts + 1)

    def places(self, name: str, borders: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the part of an axis, between borders, that each member is in, from 0."""
        known = self.members.values[name]
        if self.members.centroids is None:  # values may be beyond the ends of the axis
            known = self.borders[name][self.cells[:, self.names.index(name)]]
        known = known + _ROUNDING * (borders[-1] - borders[0])
        return np.asarray(np.searchsorted(borders[1:-1], known, side="right"), np.int64)

    def _best_within(
        self,
        names: tuple[str, ...],
        borders: tuple[NDArray[np.float64], ...],
        shape: tuple[int, ...],
    ) -> NDArray[np.int64]:
        places = [self.places(name, ends) for name, ends in zip(names, borders, strict=True)]
        numbers = np.full(shape, EMPTY, np.int64)
        # Of several members in a cell, the last assignment remains: the best, of equals the first.
        order = np.argsort(self.members.scores[::-1], kind="stable")
        order = len(order) - 1 - order
        numbers[tuple(place[order] for place in places)] = order + 1
        return numbers

    def _around_middles(
        self, names: tuple[str, ...], borders: tuple[NDArray[np.float64], ...]
    ) -> NDArray[np.int64]:
        from scipy.spatial import KDTree

        centroids = self.members.centroids
        assert centroids is not None
        columns = [self.names.index(name) for name in names]
        ends = np.array([self.borders[name][[0, -1]] for name in names])
        low, width = ends[:, 0], ends[:, 1] - ends[:, 0]
        middles = np.stack(
            np.meshgrid(*((one[:-1] + one[1:]) / 2 for one in borders), indexing="ij"), axis=-1
        )
        tree = KDTree((centroids[:, columns] - low) / width)
        _, nearest = tree.query((middles - low) / width)
        held = np.full(len(centroids), EMPTY, np.int64)
        held[self.cells[:, 0]] = np.arange(1, len(self.cells) + 1)
        return held[nearest]


def lowest(scores: NDArray[np.float64]) -> tuple[float, bool]:
    """Return the score of the darkest colour of a map, and whether there are some below it.

    A few bad elites would else take most of the colours.
    """
    least, usual, most = np.quantile(scores, [0, _FEW, 1])
    few = most - usual < 0.75 * (most - least)
    return float(usual if few else least), bool(few)
