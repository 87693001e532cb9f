"""Emitters: several parallel CMA-ES, each of which maximises the improvement of the archive.

Hansen 2016, "The CMA evolution strategy: a tutorial", with positive weights; restarts and
selection of Fontaine et al. 2020 as in pyribs (Tjanaka et al. 2023). All lengths are in widths of
the genes' bounds.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Genomes, RealSpace, State
from gaitsim.plugin.toolkit import exp, log, matmul, power, principal_axes, standard_normal
from gaitsim_searches.archive import Archive, Candidates
from gaitsim_searches.real import differences


@dataclass(frozen=True)
class SoftThresholds:
    """Parameters of thresholds that rise slowly, so that a cell rewards several improvements.

    Attributes:
        minimum: threshold of an empty cell.
        rate: learning rate of the thresholds, 0 to 1.
    """

    minimum: float
    rate: float


@dataclass(frozen=True, eq=False)
class Improvement:
    """Improvement of an archive by each candidate, compared with the archive before the batch.

    Attributes:
        status: 2 if a candidate discovers a cell, 1 if it improves a cell, otherwise 0,
            (candidates,) int64.
        gain: score minus the threshold of the cell, (candidates,); −inf for an invalid candidate.
    """

    status: NDArray[np.int64]
    gain: NDArray[np.float64]


def improvement(
    archive: Archive, candidates: Candidates, soft: SoftThresholds | None
) -> Improvement:
    """Return the improvement by each candidate.

    Without soft thresholds, the gain of a candidate that discovers a cell is its score, as in
    Fontaine, Togelius, Nikolaidis and Hoover 2020, "Covariance matrix adaptation for the rapid
    illumination of behavior space".
    """
    empty = soft.minimum if soft else -np.inf
    limits = archive.lookup(candidates.cells, archive.thresholds, empty)
    occupied = archive.lookup(candidates.cells, np.ones(len(archive.cells)), 0) > 0
    accepted = candidates.valid & (candidates.scores > limits)
    gain = candidates.scores - np.where(occupied, limits, soft.minimum if soft else 0)
    return Improvement(
        np.where(accepted, np.where(occupied, 1, 2), 0), np.where(candidates.valid, gain, -np.inf)
    )


def with_soft_thresholds(
    before: Archive, after: Archive, candidates: Candidates, soft: SoftThresholds
) -> Archive:
    """Return the archive after an insertion, with the thresholds of CMA-MAE.

    Every candidate above the threshold of its cell moves the threshold towards its score; a whole
    batch is applied at once (Fontaine and Nikolaidis 2023, "Covariance matrix adaptation
    MAP-annealing", appendix).
    """
    thresholds = before.lookup(after.cells, before.thresholds, soft.minimum)
    accepted = improvement(before, candidates, soft).status > 0
    slots = np.searchsorted(after.cells, candidates.cells[accepted])
    counts = np.bincount(slots, minlength=len(thresholds))
    sums = np.bincount(slots, candidates.scores[accepted], len(thresholds))
    kept = power(1 - soft.rate, counts)
    moved = kept * thresholds + (1 - kept) * sums / np.maximum(counts, 1)
    return replace(after, thresholds=np.where(counts > 0, moved, thresholds))


_PREFIX = "emitters "
_CONDITION = 1e14  # largest condition number of a covariance
_SMALLEST = 1e-11  # smallest standard deviation worth sampling, in widths
_ZERO = 1e-300  # smallest variance, so that lengths stay positive

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Emitters:
    """Normal distributions of genomes, one for each emitter.

    Attributes:
        mean: genome at the centre, in the genes' units, (emitters, genes).
        step: step size, (emitters,).
        covariance: covariance matrix, (emitters, genes, genes).
        basis: eigenvectors of the covariance at age `decomposed`, (emitters, genes, genes).
        lengths: square roots of the eigenvalues, (emitters, genes).
        path: evolution path, (emitters, genes).
        conjugate: conjugate evolution path, (emitters, genes).
        age: generations since the start, (emitters,) int64.
        decomposed: age at the last decomposition, (emitters,) int64.
    """

    mean: Floats
    step: Floats
    covariance: Floats
    basis: Floats
    lengths: Floats
    path: Floats
    conjugate: Floats
    age: NDArray[np.int64]
    decomposed: NDArray[np.int64]

    @classmethod
    def create(cls, mean: Floats, step: float) -> Self:
        """Return new emitters whose means are these genomes, (emitters, genes)."""
        count, genes = mean.shape
        unit = np.tile(np.eye(genes), (count, 1, 1))
        none, zeros = np.zeros(count, np.int64), np.zeros((count, genes))
        return cls(
            mean,
            np.full(count, step),
            unit,
            unit,
            np.ones((count, genes)),
            zeros,
            zeros,
            none,
            none,
        )

    @classmethod
    def from_state(cls, state: State) -> Self:
        """Return the emitters in a state."""
        return cls(**{field.name: state[_PREFIX + field.name] for field in fields(cls)})

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Return the arrays of a state by name."""
        return {_PREFIX + field.name: getattr(self, field.name) for field in fields(self)}

    def is_consistent(self, genes: int) -> bool:
        """Return whether the arrays are consistent and fit this number of genes."""
        count = len(self.mean)
        return (
            self.mean.shape
            == self.lengths.shape
            == self.path.shape
            == self.conjugate.shape
            == (count, genes)
            and self.covariance.shape == self.basis.shape == (count, genes, genes)
            and self.step.shape == self.age.shape == self.decomposed.shape == (count,)
            and all(np.isfinite(array).all() for array in self.arrays().values())
            and bool((self.step > 0).all() and (self.lengths > 0).all())
        )

    def sample(self, each: int, width: Floats, rng: np.random.Generator) -> Floats:
        """Draw `each` genomes per emitter, (each, emitters, genes); they may be out of bounds."""
        normal = standard_normal(rng, (len(self.mean), each, len(width)))
        spread = matmul(normal * self.lengths[:, None], self.basis.swapaxes(1, 2))
        return (self.mean[:, None] + self.step[:, None, None] * spread * width).swapaxes(0, 1)

    def replaced(self, which: NDArray[np.bool_], by: Self) -> Self:
        """Replace the emitters for which `which` is true by those of `by`."""
        return replace(
            self,
            **{
                field.name: np.where(
                    which.reshape(-1, *[1] * (getattr(self, field.name).ndim - 1)),
                    getattr(by, field.name),
                    getattr(self, field.name),
                )
                for field in fields(self)
            },
        )

    def exhausted(self) -> NDArray[np.bool_]:
        """Return whether each emitter has contracted or degenerated, (emitters,)."""
        longest, shortest = self.lengths.max(1), self.lengths.min(1)
        ended: NDArray[np.bool_] = np.square(longest) > _CONDITION * np.square(shortest)
        ended |= self.step * longest < _SMALLEST
        return ended

    def adapted(self, changes: Floats, parents: NDArray[np.int64], width: Floats) -> Self:
        """Return the emitters after a generation.

        Args:
            changes: genomes minus the mean in widths, best first, (emitters, each, genes).
            parents: number of best genomes that are parents, (emitters,); 0 changes only the age.
            width: distance between the bounds of each gene, (genes,).
        """
        genes, each = self.mean.shape[1], changes.shape[1]
        weights, mass = _weights(parents, each)
        path_rate, rank_one, rank_mu, step_rate, damping = _rates(mass, genes)
        change = matmul(weights[:, None], changes)[:, 0]
        shift = change / self.step[:, None]
        along = matmul(shift[:, None], self.basis) / self.lengths[:, None]
        white = matmul(along, self.basis.swapaxes(1, 2))[:, 0]
        conjugate = _updated_path(self.conjugate, step_rate, mass, white)
        age = self.age + 1
        longer = np.square(conjugate).sum(1) / genes
        rising = longer / (1 - power(1 - step_rate, 2 * age)) < 2 + 4 / (genes + 1)
        path = _updated_path(self.path, path_rate, mass, shift * rising[:, None])
        missing = ~rising * path_rate * (2 - path_rate)
        scaled = changes / self.step[:, None, None]
        covariance = (
            (1 - rank_one * (1 - missing) - rank_mu)[:, None, None] * self.covariance
            + rank_one_update(path, rank_one)
            + rank_mu[:, None, None] * matmul((scaled * weights[..., None]).swapaxes(1, 2), scaled)
        )
        growth = np.minimum(1, step_rate / damping * (longer - 1) / 2)
        adapted = replace(
            self,
            mean=self.mean + change * width,
            step=self.step * exp(growth),
            covariance=covariance,
            path=path,
            conjugate=conjugate,
        )
        return replace(self.replaced(parents > 0, adapted), age=age)._decomposed(each)

    def _decomposed(self, each: int) -> Self:
        """Decompose covariances, rarely enough that the cost per genome grows as genes²."""
        genes = self.mean.shape[1]
        _, mass = _weights(np.array([each // 2]), each)
        _, rank_one, rank_mu, _, _ = _rates(mass, genes)
        pause = 0.5 / ((rank_one + rank_mu) * genes)
        due = self.age > self.decomposed + pause
        if not due.any():
            return self
        basis, lengths = self.basis.copy(), self.lengths.copy()
        for emitter in np.flatnonzero(due):
            # Along the axes of the last decomposition, a covariance is nearly diagonal and needs
            # a third of the sweeps.
            before = basis[emitter]
            variances, turns = principal_axes(
                matmul(matmul(before.T, self.covariance[emitter]), before)
            )
            basis[emitter] = matmul(before, turns.T)
            lengths[emitter] = np.sqrt(np.maximum(variances, _ZERO))
        return replace(
            self, basis=basis, lengths=lengths, decomposed=np.where(due, self.age, self.decomposed)
        )


def rank_one_update(path: Floats, rate: Floats) -> Floats:
    """Return the rank-one update of covariances for paths, (emitters, genes), and rates."""
    return rate[:, None, None] * path[:, :, None] * path[:, None]


def _weights(parents: NDArray[np.int64], each: int) -> tuple[Floats, Floats]:
    """Return the weights of the ranks, (emitters, each), and the effective mass, (emitters,)."""
    ranks = np.arange(1, each + 1)
    raw = np.maximum(log(parents[:, None] + 0.5) - log(ranks), 0)
    raw[parents == 0, 0] = 1
    weights = raw / raw.sum(1, keepdims=True)
    return weights, 1 / np.square(weights).sum(1)


def _rates(mass: Floats, genes: int) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return the learning rates of path, rank one, rank µ and step size, and the step's damping."""
    path = (4 + mass / genes) / (genes + 4 + 2 * mass / genes)
    rank_one = 2 / (np.square(genes + 1.3) + mass)
    rank_mu = np.minimum(1 - rank_one, 2 * (mass - 2 + 1 / mass) / (np.square(genes + 2) + mass))
    step = (mass + 2) / (genes + mass + 5)
    damping = 1 + 2 * np.maximum(0, np.sqrt((mass - 1) / (genes + 1)) - 1) + step
    return path, rank_one, rank_mu, step, damping


def _updated_path(path: Floats, rate: Floats, mass: Floats, shift: Floats) -> Floats:
    """Return evolution paths, (emitters, genes), after a generation that moved by `shift`."""
    return (1 - rate)[:, None] * path + np.sqrt(rate * (2 - rate) * mass)[:, None] * shift


_FLAT = 1e-12  # range of gains below which an emitter has no direction to climb


def draw_genomes(
    emitters: Emitters, population: int, space: RealSpace, rng: np.random.Generator
) -> Genomes:
    """Draw genomes from all emitters in turn, (population, genes); they may be out of bounds."""
    each = -(-population // len(emitters.mean))
    drawn = emitters.sample(each, space.width, rng)
    return drawn.reshape(-1, space.genes)[:population]


def adapt_emitters(
    emitters: Emitters, genomes: Genomes, found: Improvement, space: RealSpace, *, two_stages: bool
) -> tuple[Emitters, NDArray[np.bool_]]:
    """Adapt each emitter to the improvement by its genomes.

    Args:
        emitters: emitters that drew the genomes.
        genomes: repaired genomes from `draw_genomes`, (population, genes).
        found: improvement of the archive by each genome.
        space: space of the genomes.
        two_stages: whether to follow CMA-ME: genomes that discover a cell rank before genomes that
            improve a cell, all of these are parents, and an emitter without parents ends.
            Otherwise CMA-MAE: genomes rank by gain alone, and the better half are parents.

    Returns:
        The adapted emitters, and whether each must restart, (emitters,).
    """
    count = len(emitters.mean)

    def by_emitter(array: NDArray[Any], missing: Any) -> NDArray[Any]:
        gap = -len(array) % count
        filled = np.concatenate([array, np.full((gap, *array.shape[1:]), missing, array.dtype)])
        return filled.reshape(-1, count, *array.shape[1:]).swapaxes(0, 1)

    gain, status = by_emitter(found.gain, -np.inf), by_emitter(found.status, 0)
    order = np.lexsort((-gain, -status) if two_stages else (-gain,))
    gain, status = (np.take_along_axis(array, order, 1) for array in (gain, status))
    changes = differences(by_emitter(genomes, 0), emitters.mean[:, None], space) / space.width
    changes = np.take_along_axis(changes, order[..., None], 1)
    valid = np.isfinite(gain).sum(1)
    drawn = by_emitter(np.ones(len(genomes), np.int64), 0).sum(1)
    parents = (status > 0).sum(1) if two_stages else np.minimum(valid, drawn // 2)
    adapted = emitters.adapted(changes, parents, space.width)
    last = np.maximum(valid - 1, 0)[:, None]
    with np.errstate(invalid="ignore"):
        span = np.abs(gain[:, :1] - np.take_along_axis(gain, last, 1))[:, 0]
    flat = (span < _FLAT) & (status[:, 0] == np.take_along_axis(status, last, 1)[:, 0])
    return adapted, (parents == 0) | (flat & (valid > 1)) | adapted.exhausted()
