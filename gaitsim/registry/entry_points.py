"""Names that installed packages register as entry points, found without importing a plugin."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from importlib.metadata import Distribution, EntryPoint, distributions, entry_points

from gaitsim.errors import PluginError, nearest

KINDS = ("organism", "fitness", "selection", "crossover", "mutation")
EXPERIMENTS = "experiments"
STUDIES = "studies"


@dataclass(frozen=True)
class Entry:
    """One name that a package registers.

    Attributes:
        kind: one of `KINDS`, `EXPERIMENTS` or `STUDIES`.
        name: the name that a user types.
        target: the object to import, `module:Class`.
        package: the distribution that registers it.
        version: the version of that distribution.
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


Entries = dict[str, list[Entry]]
"""By name, sorted. More than one entry under a name is a conflict between packages."""

_cache: ContextVar[dict[str, Entries] | None] = ContextVar("cached_entries", default=None)


@contextmanager
def cached_entries() -> Iterator[None]:
    """Read the entry points once in the block, which takes 20 ms each time without it."""
    token = _cache.set({})
    try:
        yield
    finally:
        _cache.reset(token)


def entries(kind: str) -> Entries:
    """Return all entries of a kind; import no plugin."""
    cache = _cache.get()
    if cache is None:
        return _read(kind)
    if kind not in cache:
        cache[kind] = _read(kind)
    return cache[kind]


def _read(kind: str) -> Entries:
    found: Entries = {}
    for point in _points(f"gaitsim.{kind}"):
        entry = _entry(kind, point)
        others = found.setdefault(entry.name, [])
        # A package that is installed and also on the path is found twice, and counts once.
        if all((entry.package, entry.target) != (other.package, other.target) for other in others):
            others.append(entry)
    return dict(sorted(found.items()))


def _points(group: str) -> Iterator[EntryPoint]:
    try:
        yield from entry_points(group=group)
    except Exception:  # what it may be depends on how some package's file is damaged
        for distribution in distributions():
            try:
                yield from distribution.entry_points.select(group=group)
            except Exception:
                continue


def _entry(kind: str, point: EntryPoint) -> Entry:
    package = version = None
    if point.dist:
        # A damaged installation has no name, or metadata that cannot be read.
        try:
            package, version = point.dist.name, point.dist.version
        except Exception:
            package = str(point.dist.locate_file(""))
    return Entry(kind, point.name, point.value, package or "unknown", version or "")


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
    except Exception:  # its metadata cannot be read either
        return "a package"


def find(kind: str, name: str) -> Entry:
    """Return the entry of that name.

    Raises:
        PluginError: there is none, or several packages claim the name.
    """
    known = entries(kind)
    what = {EXPERIMENTS: "experiment", STUDIES: "study"}.get(kind, f"{kind} plugin")
    if name not in known:
        raise PluginError(
            f"unknown {what} {name!r}",
            allowed=", ".join(known) or f"none: no installed package has any {what}",
            remedy=nearest(name, list(known)),
        )
    claims = known[name]
    if len(claims) > 1:
        raise PluginError(
            f"the name {name!r} of a {what} is claimed more than once: "
            + " and ".join(f"by {claim.source} ({claim.target})" for claim in claims),
            remedy="uninstall one of them, or ask its author to choose another name",
        )
    return claims[0]
