"""Views of an archive along one or two axes: the best elite in each cell of a panel."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Members
from gaitsim.render.ticks import round_step

EMPTY = -1  # stands for the number of a member in an empty cell
_MAX_LOW_SHARE = 0.1  # maximum share of cells below the colour scale of a map
MAX_PARTS = 60  # default maximum number of parts of an axis in a panel
_MANY_CELLS = 4_000  # with this many Voronoi cells or more, axes have twice as many parts
_ROUNDING = 1e-9  # share of an axis added to values, so that values on a border are above it
_ALL_PAIRS = 4  # with more axes than this, the pairs of opposite legs are shown first


@dataclass(frozen=True, eq=False)
class Panel:
    """The best elites in the cells of one or two axes, across all other axes.

    Attributes:
        names: names of the axes, one or two.
        borders: ascending borders of the cells along each axis, (cells + 1,) each.
        scores: best score in each cell, with an axis for each name; NaN in empty cells.
        members: number of the member with that score, counted from 1, int64; `EMPTY` in empty
            cells.
    """

    names: tuple[str, ...]
    borders: tuple[NDArray[np.float64], ...]
    scores: NDArray[np.float64]
    members: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ArchiveView:
    """An archive with known cells.

    Attributes:
        members: the elites.
        cells: indices of the members' cells, as in `Members.cells`.
        borders: borders of the cells along each axis, by its name, as in `Members.borders`.
    """

    members: Members
    cells: NDArray[np.int64]
    borders: dict[str, NDArray[np.float64]]

    @classmethod
    def of(cls, members: Members | None) -> "ArchiveView | None":
        """Return the view of an archive; None for members without cells, such as a front."""
        if members is None or members.cells is None or members.borders is None:
            return None
        return cls(members, members.cells, dict(members.borders))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the axes."""
        return tuple(self.borders)

    @property
    def total(self) -> int:
        """Number of cells, including empty ones."""
        centroids = self.members.centroids
        if centroids is not None:
            return len(centroids)
        return int(np.prod([len(borders) - 1 for borders in self.borders.values()]))

    @property
    def coverage(self) -> str:
        """The number of occupied cells, such as '312 of 400 cells (78.0%)'."""
        count = len(self.members.scores)
        return f"{count:,} of {self.total:,} cells ({count / self.total:.1%})"

    @property
    def best(self) -> int | None:
        """Number of the member with the highest score; None for an empty archive."""
        scores = self.members.scores
        return int(np.argmax(scores)) + 1 if len(scores) else None

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """The pairs of axes, in the order in which to show them.

        With more than four axes, each axis of the first half is first paired with its counterpart
        in the second half, which is the opposite leg for legs named L1, L2 … R1, R2 ….
        """
        names, half = self.names, (len(self.names) + 1) // 2
        pairs = tuple(combinations(names, 2))
        if len(names) <= _ALL_PAIRS:
            return pairs
        opposite = tuple(zip(names[:half], names[half:], strict=False))
        return opposite + tuple(pair for pair in pairs if pair not in opposite)

    def panel(self, *names: str, most: tuple[int, ...] = (MAX_PARTS, MAX_PARTS)) -> Panel:
        """Return the best elites along one or two axes, across all other axes.

        A grid keeps its cells, but merges neighbours if an axis has more than `most` cells. The
        axes of a tessellation are divided into equal parts. A part shows its best elite, or, if
        the tessellation has no other axes, the Voronoi cell around the middle of the part.

        Args:
            names: names of one or two axes.
            most: maximum number of cells along each axis.
        """
        borders = tuple(
            self.part_borders(name, count) for name, count in zip(names, most, strict=False)
        )
        shape = tuple(len(one) - 1 for one in borders)
        if self.members.centroids is not None and len(names) == len(self.names):
            numbers = self._voronoi_members(names, borders)
        else:
            numbers = self._best_members(names, borders, shape)
        scores = np.full(shape, np.nan)
        known = numbers != EMPTY
        scores[known] = self.members.scores[numbers[known] - 1]
        return Panel(names, borders, scores, numbers)

    def part_borders(self, name: str, most: int = MAX_PARTS) -> NDArray[np.float64]:
        """Return the borders between the parts of an axis in a panel, (parts + 1,)."""
        borders = self.borders[name]
        if self.members.centroids is None:
            together = -(-(len(borders) - 1) // most)
            inner = borders[:-1:together]
            return np.append(inner, borders[-1])
        if len(self.names) <= 2:
            parts = max(8, round(1.5 * self.total ** (1 / len(self.names))))
        else:
            # The width of parts is a round number. Values are often multiples of one, such as
            # 1/20 for duty factors in strides of 20 frames; narrower parts would remain empty.
            span = borders[-1] - borders[0]
            parts = max(
                1, round(span / round_step(span / (20 if self.total >= _MANY_CELLS else 10)))
            )
        while parts > most:
            parts = -(-parts // 2)
        return np.linspace(borders[0], borders[-1], parts + 1)

    def part_indices(self, name: str, borders: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the index of each member's part of an axis, given the borders of the parts."""
        known = self.members.values[name]
        if self.members.centroids is None:  # values may be beyond the ends of the axis
            known = self.borders[name][self.cells[:, self.names.index(name)]]
        known = known + _ROUNDING * (borders[-1] - borders[0])
        return np.asarray(np.searchsorted(borders[1:-1], known, side="right"), np.int64)

    def _best_members(
        self,
        names: tuple[str, ...],
        borders: tuple[NDArray[np.float64], ...],
        shape: tuple[int, ...],
    ) -> NDArray[np.int64]:
        places = [self.part_indices(name, ends) for name, ends in zip(names, borders, strict=True)]
        numbers = np.full(shape, EMPTY, np.int64)
        # The last assignment to a cell wins, so the best member comes last; of members with equal
        # scores, the first one.
        order = np.argsort(self.members.scores[::-1], kind="stable")
        order = len(order) - 1 - order
        numbers[tuple(place[order] for place in places)] = order + 1
        return numbers

    def _voronoi_members(
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


def colour_scale_low(scores: NDArray[np.float64]) -> tuple[float, bool]:
    """Return the score at the low end of a colour scale, and whether lower scores exist.

    Leaving out a few bad elites keeps them from taking most of the colours.
    """
    least, usual, most = np.quantile(scores, [0, _MAX_LOW_SHARE, 1])
    few = most - usual < 0.75 * (most - least)
    return float(usual if few else least), bool(few)
