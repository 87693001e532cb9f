"""One generation of emitters: draw genomes, and adapt the emitters to the results."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, RealSpace
from gaitsim_searches.emitters import Emitters
from gaitsim_searches.improvement import Improvement
from gaitsim_searches.real import differences

_FLAT = 1e-12  # range of gains below which an emitter has no direction to climb


def draw_genomes(
    emitters: Emitters, population: int, space: RealSpace, rng: np.random.Generator
) -> Genomes:
    """Draw genomes from all emitters in turn, (population, genes); they may be out of bounds."""
    each = -(-population // len(emitters.mean))
    drawn = emitters.sample(each, space.width, rng)
    return drawn.reshape(-1, space.genes)[:population]


def adapt_emitters(
    emitters: Emitters,
    genomes: Genomes,
    found: Improvement,
    space: RealSpace,
    *,
    two_stages: bool,
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
