"""Plugins by name, from installed packages' entry points.

Three grains: list the names without importing anything, load exactly one and raise,
load all and report what failed.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, NoReturn

from gaitsim.errors import GaitsimError, PluginError, nearest

if TYPE_CHECKING:
    from gaitsim.contracts import Plugin

KINDS = ("organism", "fitness", "selection", "crossover", "mutation")
EXPERIMENTS = "experiments"


@dataclass(frozen=True)
class Entry:
    """One name that a package registers.

    Attributes:
        kind: one of `KINDS`, or `EXPERIMENTS`.
        name: what a user types.
        target: what is imported for it, `module:Class`.
        package: the distribution that registers it.
        version: the version of that distribution.
    """

    kind: str
    name: str
    target: str
    package: str
    version: str

    def __str__(self) -> str:
        return f"{self.kind} {self.name!r} of package {self.package} {self.version}"


def _entry(kind: str, point: EntryPoint) -> Entry:
    package, version = (point.dist.name, point.dist.version) if point.dist else ("unknown", "")
    return Entry(kind, point.name, point.value, package, version)


def entries(kind: str) -> dict[str, list[Entry]]:
    """All entries of a kind by name, sorted; imports no plugin.

    More than one entry under a name is a conflict between packages. The same entry met
    twice, as when a package is installed and also on the path, counts once.
    """
    found: dict[str, list[Entry]] = {}
    for point in entry_points(group=f"gaitsim.{kind}"):
        entry = _entry(kind, point)
        others = found.setdefault(entry.name, [])
        if all((entry.package, entry.target) != (other.package, other.target) for other in others):
            others.append(entry)
    return dict(sorted(found.items()))


def find(kind: str, name: str) -> Entry:
    """The entry of that name.

    Raises:
        PluginError: there is none, or two packages claim the name.
    """
    known = entries(kind)
    what = "experiment" if kind == EXPERIMENTS else f"{kind} plugin"
    if name not in known:
        raise PluginError(
            f"unknown {what} {name!r}",
            allowed=", ".join(known) or f"none: no installed package has any {what}",
            remedy=nearest(name, list(known)),
        )
    claims = known[name]
    if len(claims) > 1:
        raise PluginError(
            f"the name {name!r} of a {what} is claimed by two packages: "
            + " and ".join(f"{claim.package} {claim.version}" for claim in claims),
            remedy="uninstall one of them, or ask its author to choose another name",
        )
    return claims[0]


@contextmanager
def containing(entry: Entry, doing: str) -> Iterator[None]:
    """Turn whatever a plugin raises into a `PluginError` that names its package."""
    try:
        yield
    except (GaitsimError, KeyboardInterrupt):
        raise
    # SystemExit, too: a plugin does not end the program.
    except BaseException as error:
        blame(entry, doing, error)


def blame(entry: Entry, doing: str, error: BaseException) -> NoReturn:
    """Raise the `PluginError` that names a plugin, what it was doing, and its exception."""
    reason = f"{type(error).__name__}: {error}".rstrip(": ")
    raise PluginError(
        f"{entry} failed while {doing}: {reason}",
        where=entry.target,
        remedy=f"update {entry.package}, or report it to its author",
    ) from error


def load_class(kind: str, name: str) -> "type[Plugin]":
    """The plugin class of that name.

    Raises:
        PluginError: unknown or doubly claimed name, an import that fails, or something
            that is not a plugin of that kind.
    """
    from gaitsim import contracts

    entry = find(kind, name)
    with containing(entry, "being imported"):
        loaded = EntryPoint(name, entry.target, f"gaitsim.{kind}").load()
    expected: type[Plugin] = getattr(contracts, kind.capitalize())
    if not (isinstance(loaded, type) and issubclass(loaded, expected)):
        raise PluginError(
            f"{entry} is not a {expected.__name__}, but {_describe(loaded)}",
            where=entry.target,
            allowed=f"a subclass of gaitsim.contracts.{expected.__name__}",
            remedy=f"correct the entry point in the pyproject.toml of {entry.package}",
        )
    abstract = sorted(getattr(loaded, "__abstractmethods__", ()))
    if abstract:
        raise PluginError(
            f"{entry} does not implement {', '.join(abstract)}",
            where=entry.target,
            remedy=f"implement every method of gaitsim.contracts.{expected.__name__}",
        )
    return loaded


def _describe(thing: object) -> str:
    return f"the class {thing.__name__}" if isinstance(thing, type) else f"a {type(thing).__name__}"


def scan(kind: str) -> "tuple[dict[str, type[Plugin]], list[PluginError]]":
    """Load every plugin of a kind: the classes by name, and what failed."""
    classes: dict[str, type[Plugin]] = {}
    failures: list[PluginError] = []
    for name in entries(kind):
        try:
            classes[name] = load_class(kind, name)
        except PluginError as error:
            failures.append(error)
    return classes, failures
