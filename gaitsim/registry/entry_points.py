"""Plugins by name, from installed packages' entry points.

Three grains: list the names without importing anything, load exactly one and raise,
load all and report what failed.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import Distribution, EntryPoint, distributions, entry_points
from types import TracebackType
from typing import TYPE_CHECKING, NoReturn

from gaitsim.errors import GaitsimError, PluginError, nearest
from gaitsim.registry.plugin_context import plugin_context

if TYPE_CHECKING:
    from gaitsim.contracts import Plugin

KINDS = ("organism", "fitness", "selection", "crossover", "mutation")
EXPERIMENTS = "experiments"
STUDIES = "studies"


@dataclass(frozen=True)
class Entry:
    """One name that a package registers.

    Attributes:
        kind: one of `KINDS`, `EXPERIMENTS` or `STUDIES`.
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
        return f"{self.kind} {self.name!r} of package {self.source}"

    @property
    def source(self) -> str:
        """The package with its version."""
        return f"{self.package} {self.version}".strip()


def _entry(kind: str, point: EntryPoint) -> Entry:
    package = version = None
    if point.dist:
        # A damaged installation has no name, or metadata that cannot be read.
        try:
            package, version = point.dist.name, point.dist.version
        except Exception:
            package = _folder(point.dist)
    return Entry(kind, point.name, point.value, package or "unknown", version or "")


def _folder(distribution: Distribution) -> str:
    return str(getattr(distribution, "_path", "unknown"))


def entries(kind: str) -> dict[str, list[Entry]]:
    """All entries of a kind by name, sorted; imports no plugin.

    More than one entry under a name is a conflict between packages. The same entry met
    twice, as when a package is installed and also on the path, counts once.
    """
    if kind in _remembered:
        return _remembered[kind]
    found: dict[str, list[Entry]] = {}
    for point in _points(f"gaitsim.{kind}"):
        entry = _entry(kind, point)
        others = found.setdefault(entry.name, [])
        if all((entry.package, entry.target) != (other.package, other.target) for other in others):
            others.append(entry)
    return dict(sorted(found.items()))


_remembered: dict[str, dict[str, list[Entry]]] = {}


@contextmanager
def cached_entries() -> Iterator[None]:
    """Read what is installed once, for who loads many experiments: 20 ms each without."""
    try:
        _remembered.update({kind: entries(kind) for kind in (*KINDS, EXPERIMENTS)})
        yield
    finally:
        _remembered.clear()


def _points(group: str) -> Iterable[EntryPoint]:
    try:
        return entry_points(group=group)
    except Exception:
        # Of some package, gaitsim's or not, the entry points cannot be read: the others can.
        return _readable_points(group)


def _readable_points(group: str) -> Iterator[EntryPoint]:
    for distribution in distributions():
        try:
            yield from distribution.entry_points.select(group=group)
        except Exception:  # what it may be depends on how the file is damaged
            continue


def unreadable() -> list[str]:
    """The folders of installed packages whose entry points cannot be read."""
    found = []
    for distribution in distributions():
        try:
            _ = distribution.entry_points
        except Exception:
            found.append(_folder(distribution))
    return found


def find(kind: str, name: str) -> Entry:
    """The entry of that name.

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


class plugin_errors(plugin_context):
    """Turn whatever a plugin raises into a `GaitsimError` that names its package.

    What it prints meanwhile goes to standard error.

    Args:
        entry: the plugin.
        doing: what it is asked to do.
    """

    __slots__ = ("_doing", "_entry")

    def __init__(self, entry: Entry, doing: str) -> None:
        super().__init__(entry, doing)
        self._entry, self._doing = entry, doing

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        super().__exit__(kind, error, trace)
        if isinstance(error, GaitsimError):
            # The plugin's own words, or ours; either way it is said whose they are.
            error.where = error.where or f"{self._entry}, {self._entry.target}"
        # SystemExit, too: a plugin does not end the program.
        elif error is not None and not isinstance(error, KeyboardInterrupt | GeneratorExit):
            raise_plugin_error(self._entry, self._doing, error)


def raise_plugin_error(entry: Entry, doing: str, error: BaseException) -> NoReturn:
    """Raise the `PluginError` that names a plugin, what it was doing, and its exception."""
    raise PluginError(
        f"{entry} failed while {doing}: {_reason(error)}",
        where=entry.target,
        remedy=f"update {entry.package}, or report it to its author",
    ) from error


def _reason(error: BaseException) -> str:
    try:
        return f"{type(error).__name__}: {error}".rstrip(": ")
    except Exception:  # its __str__ is the plugin's, too
        return type(error).__name__


def load_class(kind: str, name: str) -> "type[Plugin]":
    """The plugin class of that name.

    Raises:
        PluginError: unknown or doubly claimed name, an import that fails, or something
            that is not a plugin of that kind.
    """
    return load_entry(find(kind, name))


def load_entry(entry: Entry) -> "type[Plugin]":
    """The plugin class of an entry, held to its contract.

    Raises:
        PluginError: an import that fails, or something that is not a plugin of that kind.
    """
    from gaitsim import contracts

    with plugin_errors(entry, "being imported"):
        loaded = EntryPoint(entry.name, entry.target, f"gaitsim.{entry.kind}").load()
    expected: type[Plugin] = getattr(contracts, entry.kind.capitalize())
    if not (isinstance(loaded, type) and issubclass(loaded, expected)):
        raise PluginError(
            f"{entry} is no {expected.__name__}, but {_describe(loaded)}",
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
    _hold_to_declarations(entry, loaded, expected)
    return loaded


def _describe(thing: object) -> str:
    return f"the class {thing.__name__}" if isinstance(thing, type) else f"a {type(thing).__name__}"


def _hold_to_declarations(entry: Entry, plugin: "type[Plugin]", contract: "type[Plugin]") -> None:
    """Refuse a class that leaves out, or gives in a wrong form, what its kind declares."""
    from gaitsim.registry.class_validation import problems

    found = problems(entry.kind, plugin)
    if found:
        raise PluginError(
            f"{entry} breaks its contract: {'; '.join(found)}",
            where=entry.target,
            remedy=f"see gaitsim.contracts.{contract.__name__}; or update {entry.package}",
        )


def scan(kind: str) -> "tuple[dict[str, type[Plugin]], list[GaitsimError]]":
    """Load every plugin of a kind: the classes by name, and what failed."""
    classes: dict[str, type[Plugin]] = {}
    failures: list[GaitsimError] = []
    for name in entries(kind):
        try:
            classes[name] = load_class(kind, name)
        except GaitsimError as error:
            failures.append(error)
    return classes, failures
