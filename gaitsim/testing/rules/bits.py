"""Bit-for-bit comparison of the results of plugins, by their digests."""

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import Motion, Organism, Skeleton


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


def changed_shapes(motion: Motion, other: Motion) -> list[str]:
    """Return the channels that have different shapes in two motions of a body."""
    return [name for name in motion if np.shape(other[name]) != np.shape(motion[name])]


def same_space(one: Organism, other: Organism) -> bool:
    """Return whether the genome spaces of two bodies draw the same genomes."""
    first, second = (
        body.genome_space().random(5, np.random.default_rng(3)) for body in (one, other)
    )
    return same(first, second)


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
