"""Keys of results: hashes of everything that a result depends on."""

import hashlib
import json
import re
from collections.abc import Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version

from gaitsim.experiment import Experiment

_OWN = "gaitsim"
# The dependencies of gaitsim that compute results. `gaitsim.runs.compatibility.versions` lists only
# loaded engines, but a key must not depend on the modules that this process has loaded.
_NUMERICAL = (_OWN, "mujoco-core", "numba", "numpy", "pymunk", "scipy")


def result_key(experiment: Experiment, repeats: int, generations: Sequence[int]) -> str:
    """Return a key of 16 hexadecimal digits for the scores of repeats.

    The key is a hash of the whole experiment, the versions of the packages that compute it, the
    number of repeats and the recorded generations. It does not change if the code of a plugin
    changes while its package keeps its version.

    Args:
        experiment: experiment to repeat.
        repeats: number of repeats.
        generations: recorded generations.
    """
    plugins = {kind: entry.source for kind, entry in experiment.entries.items()}
    packages = {entry.package for entry in experiment.entries.values()}
    used = {*_NUMERICAL, *(name for package in packages for name in _requirements(package))}
    versions = {name: _version(name) for name in used} | plugins
    parts = [experiment.to_dict(), versions, repeats, [*generations]]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


@cache
def _requirements(package: str) -> tuple[str, ...]:
    """Return the packages that a package other than gaitsim requires."""
    if package == _OWN:
        return ()  # `_NUMERICAL` lists those of its requirements that compute results
    try:
        given = requires(package) or ()
    except PackageNotFoundError:
        return ()
    # "jax>=0.4; python_version > '3.10'" requires jax.
    return tuple(re.split(r"[^\w.-]", text.strip(), maxsplit=1)[0] for text in given)


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # an extra requires it, and it is not installed
        return ""
