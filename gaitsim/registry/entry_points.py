"""Entry points of installed packages, listed without importing any plugin."""

import os
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import Distribution, EntryPoint, distributions

from gaitsim.errors import PluginError, nearest

KINDS = ("organism", "fitness", "search", "selection", "crossover", "mutation")
"""The kinds of plugin; the last three are the operators of a search that uses them."""
EXPERIMENTS = "experiments"
STUDIES = "studies"
FILES = "files"
"""File formats that describe a body: the name of the entry point is the suffix of the files."""
PYTHON = "python:"
"""Prefix of the names of functions and classes that a user passes in Python."""


@dataclass(frozen=True)
class Entry:
    """One name that a package registers.

    Attributes:
        kind: one of `KINDS`, `EXPERIMENTS`, `STUDIES` or `FILES`.
        name: name that a user types.
        target: object to import, `module:Class`.
        package: distribution that registers the name.
        version: version of the distribution.
    """

    kind: str
    name: str
    target: str
    package: str
    version: str

    def __str__(self) -> str:
        return f"{self.kind} {self.name!r} of package {self.source}"

    @property
    def source(self) -> str:
        """The package with its version."""
        return f"{self.package} {self.version}".strip()

    @property
    def remedy(self) -> str:
        """The remedy for a violation of the plugin's contract."""
        return (
            f"if the plugin is yours, 'gaitsim plugins check {self.name}' lists its errors; "
            f"otherwise update {self.package}, or report the error to its author"
        )

    def place_of(self, error: BaseException) -> str:
        """Return the place of an error of the plugin, for the message."""
        return self.target


Entries = Mapping[str, Sequence[Entry]]
"""Entries by name, sorted; more than one entry under a name is a conflict between packages."""

_GROUPS = {f"gaitsim.{kind}": kind for kind in (*KINDS, EXPERIMENTS, STUDIES, FILES)}


def entries(kind: str) -> Entries:
    """Return all entries of a kind, without importing any plugin."""
    return _read(tuple(map(_state, sys.path)))[kind]


def _state(folder: str) -> tuple[object, ...]:
    """Return a key that changes when a package is installed into or removed from a folder."""
    try:
        found = os.stat(folder or ".")  # noqa: PTH116 - an entry of sys.path may be any text
    except (OSError, ValueError):
        return (folder,)
    return folder, found.st_dev, found.st_ino, found.st_mtime_ns


@lru_cache(maxsize=1)  # reading takes 5 ms, and loading an experiment looks up six names
def _read(path: tuple[object, ...]) -> dict[str, Entries]:
    """Return all entries by kind.

    Args:
        path: state of each folder on `sys.path`, the key of the cache.
    """
    found: dict[str, dict[str, list[Entry]]] = {kind: {} for kind in _GROUPS.values()}
    packages: set[str] = set()
    for distribution in distributions():
        points = [point for point in _points(distribution) if point.group in _GROUPS]
        if not points:
            continue
        package, version = _package(distribution)
        if normalized(package) in packages:  # Python imports the first one on the path
            continue
        packages.add(normalized(package))
        for point in points:
            kind = _GROUPS[point.group]
            claims = found[kind].setdefault(point.name, [])
            entry = Entry(kind, point.name, point.value, package, version)
            if entry not in claims:
                claims.append(entry)
    return {kind: dict(sorted(names.items())) for kind, names in found.items()}


def _points(distribution: Distribution) -> Sequence[EntryPoint]:
    try:
        return distribution.entry_points
    except Exception:  # the type depends on how the file is damaged
        return ()


def _package(distribution: Distribution) -> tuple[str, str]:
    """Return name and version; the folder replaces the name if the metadata is damaged."""
    folder = str(distribution.locate_file(""))
    try:
        return distribution.name or folder, distribution.version or ""
    except Exception:
        return folder, ""


def normalized(package: str) -> str:
    """Return the normalized name of a package, as package indexes compare names."""
    return re.sub(r"[-_.]+", "-", package).lower()


def unreadable() -> list[str]:
    """Return the installed packages whose entry points cannot be read, with their folders."""
    found = []
    for distribution in distributions():
        try:
            _ = distribution.entry_points
        except Exception:
            found.append(f"{_name(distribution)} in {distribution.locate_file('')}")
    return found


def _name(distribution: Distribution) -> str:
    try:
        return distribution.name or "a package"
    except Exception:  # the metadata cannot be read either
        return "a package"


def find(kind: str, name: str) -> Entry:
    """Return the entry of a kind with a name."""
    if name.startswith(PYTHON) and kind in KINDS:
        from gaitsim.registry.python_entries import find_registered  # avoids a cyclic import

        return find_registered(kind, name)
    known = entries(kind)
    what = {EXPERIMENTS: "experiment", STUDIES: "study", FILES: "format"}.get(
        kind, f"{kind} plugin"
    )
    if name not in known:
        raise PluginError(
            f"unknown {what} {name!r}",
            allowed=", ".join(known) or f"none, because no installed package provides a {what}",
            remedy=nearest(name, list(known)),
        )
    claims = known[name]
    if len(claims) > 1:
        raise PluginError(
            f"the {what} name {name!r} is registered more than once: "
            + " and ".join(f"by {claim.source} ({claim.target})" for claim in claims),
            remedy="uninstall one of them, or ask its author to choose another name",
        )
    return claims[0]
