"""Compare the results of plugins bit for bit, by their digests."""

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import Motion, Organism, Skeleton


def digest(thing: object) -> str:
    """Return the SHA-256 of arrays, motions, skeletons, strings, numbers, or nested values."""
    found = hashlib.sha256()
    _add(found, thing)
    return found.hexdigest()


def _add(found: Any, thing: object) -> None:
    if isinstance(thing, np.ndarray):
        found.update(f"{thing.dtype} {thing.shape}".encode())
        found.update(np.ascontiguousarray(thing).tobytes())
    elif isinstance(thing, Motion):
        _add(found, {"rate": thing.frame_rate, "failures": sorted(thing.failures.items())})
        _add(found, {name: thing[name] for name in sorted(thing)})
    elif isinstance(thing, Skeleton):
        _add(found, [thing.segments, thing.contacts, thing.touching, thing.path, thing.poses])
    elif isinstance(thing, Mapping):
        for key, value in thing.items():
            _add(found, str(key))
            _add(found, value)
    elif isinstance(thing, Sequence) and not isinstance(thing, str):
        for item in thing:
            _add(found, item)
    else:
        found.update(repr(thing).encode())


def same(one: object, other: object) -> bool:
    """Return whether two values are identical bit for bit; NaN equals NaN."""
    return digest(one) == digest(other)


def other_shapes(motion: Motion, other: Motion) -> list[str]:
    """Return the channels of a motion that have a different shape in another motion."""
    return [name for name in motion if np.shape(other[name]) != np.shape(motion[name])]


def same_space(one: Organism, other: Organism) -> bool:
    """Return whether two bodies draw the same genomes."""
    first, second = (
        body.genome_space().random(5, np.random.default_rng(3)) for body in (one, other)
    )
    return same(first, second)


def rows(motion: Motion, chosen: Sequence[int]) -> dict[str, Any]:
    """Return the channels and failures of some individuals, as in a separate chunk."""
    chosen = list(chosen)
    return {
        "failures": {i: motion.failures[k] for i, k in enumerate(chosen) if k in motion.failures},
        **{name: np.asarray(motion[name])[chosen] for name in motion},
    }


def differing(one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """Return the first key at which two dicts of arrays differ; '' for none."""
    for name in dict.fromkeys([*one, *other]):
        if name not in one or name not in other or not same(one[name], other[name]):
            return name
    return ""
