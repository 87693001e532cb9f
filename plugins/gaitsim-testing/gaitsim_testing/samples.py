"""Helpers of the checks: bit-for-bit comparison by digests, and valid populations."""

import hashlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim.plugin import (
    BitSpace,
    Crossover,
    Entry,
    Genomes,
    GenomeSpace,
    Motion,
    Mutation,
    Organism,
    Plugin,
    RealSpace,
    Search,
    Skeleton,
)
from gaitsim.plugin.runs import check_motion, space_of
from gaitsim_testing.finding import require_type


def digest(value: object) -> str:
    """Return the SHA-256 of arrays, motions, skeletons, strings, numbers, or nested values."""
    sha = hashlib.sha256()
    _add(sha, value)
    return sha.hexdigest()


def _add(sha: Any, value: object) -> None:
    if isinstance(value, np.ndarray):
        sha.update(f"{value.dtype} {value.shape}".encode())
        sha.update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, Motion):
        _add(sha, {"rate": value.frame_rate, "failures": sorted(value.failures.items())})
        _add(sha, {name: value[name] for name in sorted(value)})
    elif isinstance(value, Skeleton):
        _add(sha, [value.segments, value.contacts, value.touching, value.path, value.poses])
    elif isinstance(value, Mapping):
        for key, item in value.items():
            _add(sha, str(key))
            _add(sha, item)
    elif isinstance(value, Sequence) and not isinstance(value, str):
        for item in value:
            _add(sha, item)
    else:
        sha.update(repr(value).encode())


def same(one: object, other: object) -> bool:
    """Return whether two values are identical bit for bit; NaN equals NaN."""
    return digest(one) == digest(other)


def select_rows(motion: Motion, indices: Sequence[int]) -> dict[str, Any]:
    """Return the channels and failures of some individuals, as if moved in a separate chunk."""
    indices = list(indices)
    return {
        "failures": {i: motion.failures[k] for i, k in enumerate(indices) if k in motion.failures},
        **{name: np.asarray(motion[name])[indices] for name in motion},
    }


def first_difference(one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """Return the first key at which two dicts of arrays differ, or ''."""
    for name in dict.fromkeys([*one, *other]):
        if name not in one or name not in other or not same(one[name], other[name]):
            return name
    return ""


GENERATIONS = (1, 2, 1000, 1_000_000)  # generations in which schedules are checked

STATELESS = "draw only from the generator 'rng', and keep no state between calls"


def _at_most_half(genomes: Genomes) -> Genomes:
    """Repair genomes with more than half of the bits set: clear the second half."""
    repaired = genomes.copy()
    repaired[genomes.sum(axis=1) > genomes.shape[1] / 2, genomes.shape[1] // 2 :] = 0
    return repaired


def sample_spaces() -> dict[str, GenomeSpace]:
    """Return genome spaces on which operators and searches are tested, by description."""
    lower = np.array([-1.0, 0.0, 1e-3, -np.pi, 10.0])
    width = np.array([2.0, 1e-6, 1.0, 2 * np.pi, 1e6])
    labels = tuple("abcde")
    return {
        "real genes": RealSpace(lower, lower + width, labels),
        "real genes, one periodic": RealSpace(
            lower,
            lower + width,
            labels,
            initial_sigma=width / 4,
            periodic=np.array([0, 0, 0, 1, 0], bool),
        ),
        "a single real gene": RealSpace(lower[:1], lower[:1] + 1, labels[:1]),
        "bits": BitSpace(tuple("abcdefg")),
        "bits with a repair": BitSpace(tuple("abcdefg"), _at_most_half),
    }


def supported_spaces(operator: Crossover | Mutation | Search) -> Iterator[tuple[str, GenomeSpace]]:
    """Yield the example genome spaces, by name, whose types an operator or search supports."""
    return (
        (what, space)
        for what, space in sample_spaces().items()
        if isinstance(space, operator.spaces)
    )


def check_schedule(plugin: Plugin, contract: type[Plugin]) -> None:
    """Check that `at` returns a plugin in early and late generations."""
    for generation in GENERATIONS:
        require_type(f"at({generation})", plugin.at(generation), contract)


def measure_rate(work: Callable[..., object], arguments: Sequence[object], count: int) -> float:
    """Return the individuals per second of a call that produces `count` individuals."""
    start = time.perf_counter()
    work(*arguments)
    return count / max(time.perf_counter() - start, 1e-9)


COUNT = 6  # number of individuals moved


def sample_genomes(space: GenomeSpace, count: int = COUNT) -> Genomes:
    """Return `count` random genomes, (count, genes).

    In a real space, the last two of more than two genomes lie at the lower and upper bounds.
    """
    genomes = space.random(count, np.random.default_rng(1))
    if isinstance(space, RealSpace) and count > 2:
        genomes[-2:] = space.repair(np.stack([space.lower, space.upper]))
    return genomes


def sample_motion(entry: Entry, body: Organism) -> Motion:
    """Return the motion of a few individuals, as input for a fitness."""
    return check_motion(entry, body.move(sample_genomes(space_of(entry, body))))
