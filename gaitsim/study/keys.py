"""Name the file of a result after everything that the result depends on."""

import hashlib
import json
import re
from collections.abc import Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version

from gaitsim.experiment import Experiment

_OWN = "gaitsim"
# Of gaitsim's dependencies, the ones that compute. `gaitsim.runs.compatibility.versions` lists
# only engines that are loaded; a key must not depend on what this process has loaded so far.
_NUMERICAL = (_OWN, "mujoco-core", "numba", "numpy", "pymunk", "scipy")


def result_key(experiment: Experiment, repeats: int, generations: Sequence[int]) -> str:
    """Return 16 hexadecimal digits of all that the scores of repeats are a function of.

    These are the whole experiment, as its file says it, the versions of the packages that
    compute it, and what is recorded. A plugin whose code changes while its package keeps its
    version has the same key.

    Args:
        experiment: the experiment that is repeated.
        repeats: number of repeats.
        generations: the recorded ones.

    Raises:
        PluginError: a plugin has an option whose value JSON cannot hold.
    """
    plugins = {kind: entry.source for kind, entry in experiment.entries.items()}
    packages = {entry.package for entry in experiment.entries.values()}
    used = {*_NUMERICAL, *(name for package in packages for name in _requirements(package))}
    versions = {name: _version(name) for name in used} | plugins
    parts = [experiment.to_dict(), versions, repeats, [*generations]]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


@cache
def _requirements(package: str) -> tuple[str, ...]:
    """Return the packages that another author's package requires."""
    if package == _OWN:
        return ()  # most of its requirements are of its screens and pictures
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
    except PackageNotFoundError:  # a requirement of an extra
        return ""
