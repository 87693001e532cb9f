"""Plugins by name: entry points of installed packages, listed without importing any plugin.

Calls into a plugin are tracked, and its errors name its package.

Fitness functions and bodies passed in Python are registered in this process alone, under names such
as `python:forward`. An experiment with a function that is not registered can be read, but its
individuals can neither move nor be scored.
"""

import os
import re
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from importlib.metadata import Distribution, distributions
from keyword import iskeyword
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from gaitsim.errors import ContractError, GaitsimError, MissingFunctionError, PluginError, nearest

if TYPE_CHECKING:
    from gaitsim.contracts import Plugin


KINDS = ("organism", "fitness", "search", "selection", "crossover", "mutation")
"""The kinds of plugin; the last three are the operators of a search that uses them."""
REFLEX = "reflex"
"""The kind of plugin that bodies with reflexes name in their options."""
PRODUCTS = ("plot", "exporter")
"""The kinds of plugin that make files from runs; experiments do not name them."""
PLUGINS = (*KINDS, REFLEX, *PRODUCTS)
"""All kinds of plugin with a contract in `gaitsim.contracts`."""
EXPERIMENTS = "experiments"
STUDIES = "studies"
FILES = "files"
"""File formats that describe a body: the name of the entry point is the suffix of the files."""
COMMANDS = "command"
"""Commands: a function for Typer, or an action; the name of one in a group has a dot. A module is a
group, whose help is the module's docstring."""
SCREENS = "screen"
"""Commands of the terminal UI: subclasses of `gaitsim.screen.ScreenCommand`."""
FUNCTIONS = "python"
"""Functions and classes that `import gaitsim as gs` offers as `gs.NAME`."""
ENGINES = "engine"
"""Physics engines of bodies that support several: a module, whose content the body determines."""
VERIFIERS = "verifier"
"""How packages verify what they store: `gaitsim.verifying.Verifier`."""
STEER = "steer"
"""Presets that menus offer for steering."""
PYTHON = "python:"
"""Prefix of the names of functions and classes that a user passes in Python."""


@dataclass(frozen=True)
class Entry:
    """One name that a package registers.

    Attributes:
        kind: one of `PLUGINS`, or of the other constants above.
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
        if self.kind == COMMANDS:
            return f"update {self.package}, or report the error to its author"
        return (
            f"if the plugin is yours, 'gaitsim plugins check {self.name}' lists its errors; "
            f"otherwise update {self.package}, or report the error to its author"
        )

    def place_of(self, error: BaseException) -> str:
        """Return the place of an error of the plugin, for the message."""
        return self.target


_NOUNS = {
    EXPERIMENTS: "experiment",
    STUDIES: "study",
    FILES: "format",
    COMMANDS: "command",
    SCREENS: "screen",
    FUNCTIONS: "function",
    ENGINES: "physics engine",
    STEER: "steered preset",
    VERIFIERS: "verifier",
    REFLEX: "reflex",
    "plot": "kind of plot",
    "exporter": "format",
}
Entries = Mapping[str, Sequence[Entry]]
"""Entries by name, sorted; more than one entry under a name is a conflict between packages."""

_GROUPS = {f"gaitsim.{kind}": kind for kind in (*KINDS, *_NOUNS)}


def entries(kind: str) -> Entries:
    """Return all entries of a kind, without importing any plugin.

    Packages that are installed into a folder of `sys.path` later are found by the next process.
    """
    return _read(tuple(sys.path))[kind]


@lru_cache(maxsize=1)  # reading takes 5 ms, and loading an experiment looks up six names
def _read(_: tuple[str, ...]) -> dict[str, Entries]:
    """Return all entries by kind; `sys.path` is the key of the cache."""
    found: dict[str, dict[str, list[Entry]]] = {kind: {} for kind in _GROUPS.values()}
    packages: set[str] = set()
    for distribution in distributions():
        try:
            # Parsing all files of a hundred packages would take 5 ms.
            if "[gaitsim." not in (distribution.read_text("entry_points.txt") or ""):
                continue
            points = distribution.entry_points
        except Exception:  # the type depends on how the file is damaged
            continue
        package, version = _package(distribution)
        name = normalized(package)
        if name in packages:  # Python imports the first one on the path
            continue
        for point in points:
            if kind := _GROUPS.get(point.group):
                packages.add(name)
                claims = found[kind].setdefault(point.name, [])
                entry = Entry(kind, point.name, point.value, package, version)
                if entry not in claims:
                    claims.append(entry)
    return {kind: dict(sorted(names.items())) for kind, names in found.items()}


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
            folder = str(distribution.locate_file(""))
            name = _package(distribution)[0]
            found.append(f"{'a package' if name == folder else name} in {folder}")
    return found


def find(kind: str, name: str) -> Entry:
    """Return the entry of a kind with a name."""
    if name.startswith(PYTHON) and kind in KINDS:
        return find_registered(kind, name)
    known = entries(kind)
    what = _NOUNS.get(kind, f"{kind} plugin")
    if name not in known:
        raise PluginError(
            f"unknown {what} {name!r}",
            allowed=", ".join(known) or f"none, because no installed package provides a {what}",
            remedy=install_hint(kind, name) or nearest(name, list(known)),
        )
    claims = known[name]
    if len(claims) > 1:
        raise PluginError(
            f"the {what} name {name!r} is registered more than once: "
            + " and ".join(f"by {claim.source} ({claim.target})" for claim in claims),
            remedy="uninstall one of them, or ask its author to choose another name",
        )
    return claims[0]


@cache
def own_packages() -> Mapping[str, Mapping[str, Sequence[str]]]:
    """Return what the packages of gaitsim provide: package -> kind -> names."""
    import tomllib

    return tomllib.loads(Path(__file__).with_name("packages.toml").read_text(encoding="utf-8"))


def install_hint(kind: str, name: str) -> str:
    """Return how to install the package of gaitsim that provides a name; '' if none does."""
    for package, kinds in own_packages().items():
        if name not in entries(kind) and name in kinds.get(kind, ()):
            return f"pip install {package} (in a clone of gaitsim: pip install plugins/{package})"
    return ""


# Shared by all threads, because Ctrl-C stops the process while plugins run in any thread.
_active: dict["plugin_context", None] = {}  # in order of entry
_interrupted: list["plugin_context"] = []


class plugin_context:  # named like contextlib.suppress; a generator takes five times as long
    """Record which plugin is running in a block, for `interrupted_plugin`.

    If the plugin forks the process with `os.fork`, the child is killed at the end of the block:
    otherwise it would write to the same run and release this process's locks.

    Args:
        entry: entry of the plugin.
        doing: task of the plugin, such as 'moving a population'.
    """

    def __init__(self, entry: Entry, doing: str) -> None:
        self.entry, self.doing = entry, doing

    def __enter__(self) -> None:
        self.place = os.getpid(), threading.get_ident()
        _active[self] = None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: object
    ) -> None:
        del _active[self]
        if isinstance(error, KeyboardInterrupt):
            _interrupted.append(self)
        if os.getpid() != self.place[0]:
            text = f"{self.entry} called os.fork while {self.doing}; the child process is killed"
            with suppress(OSError):
                os.write(2, f"Warning: {text}\n".encode())  # the lock of sys.stderr may be held
            _end_process(2)


class plugin_errors(plugin_context):
    """Convert any exception of a plugin in a block to a `GaitsimError` that names its package.

    Args:
        entry: entry of the plugin.
        doing: task of the plugin, such as 'moving a population'.
    """

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: object
    ) -> None:
        entry, doing = self.entry, self.doing
        try:
            if error is None:
                _check_descriptors(entry, doing)
            elif isinstance(error, GaitsimError):
                error.where = error.where or f"{entry}, {entry.target}"
            elif not isinstance(error, KeyboardInterrupt | GeneratorExit):
                try:
                    reason = f"{type(error).__name__}: {error}".rstrip(": ")
                except Exception:  # `__str__` may be the plugin's code
                    reason = type(error).__name__
                failed = contract_error(entry, f"failed while {doing}: {reason}")
                failed.where = entry.place_of(error)
                raise failed from error  # also for SystemExit: a plugin must not end the program
        finally:
            super().__exit__(kind, error, traceback)


def contract_error(entry: Entry, what: str, allowed: str = "") -> ContractError:
    """Return the error for a plugin that fails or breaks its contract; it names the package."""
    return ContractError(
        f"{entry} {what}", where=entry.target, allowed=allowed, remedy=entry.remedy
    )


def interrupted_plugin() -> str:
    """Return the plugin that Ctrl-C interrupted and its task, once; '' if there is none."""
    # The innermost call is recorded first; other threads may still be inside theirs.
    calls = [*_interrupted[:1], *list(_active)[-1:]]
    _interrupted.clear()
    return f"{calls[0].entry} was {calls[0].doing}" if calls else ""


_end_process = os._exit
_errors: list[int] = []  # a duplicate of the descriptor of standard error, once guarded


def guard_process() -> None:
    """Keep plugins from ending the process or closing its output; further calls do nothing.

    In a plugin, `os._exit` raises SystemExit, so that gaitsim reports the call and closes the run.
    """
    if os._exit is not _exit:
        os._exit = _exit
        with suppress(OSError):  # closed by the caller
            _errors.append(os.dup(2))


def _exit(status: int) -> NoReturn:
    here = os.getpid(), threading.get_ident()
    if any(call.place == here for call in [*_active]):
        raise SystemExit(f"os._exit({status})")
    _end_process(status)


def _check_descriptors(entry: Entry, doing: str) -> None:
    """Raise an error if a plugin closed standard output or error.

    The next file that is opened would reuse the descriptor, and messages would be written to it.
    """
    closed = []
    for number in (1, 2) if _errors else ():
        try:
            # Unlike fstat, this call keeps the interpreter lock, so it never waits.
            os.get_inheritable(number)
        except OSError:
            closed.append(number)
            with suppress(OSError):
                os.dup2(_errors[0], number)
    if closed:
        names = " and ".join(f"file descriptor {number}" for number in closed)
        raise contract_error(entry, f"closed {names} while {doing}", "only files that it opened")


OUTSIDE = "Python code outside the run"
"""The text shown instead of a package for plugins passed in Python."""
ARGUMENTS = {"fitness": "fitness", "organism": "body"}
"""The argument of `gs.evolve` for a plugin of a kind."""
SCORE = f"{PYTHON}score"
"""The name of the fitness for a body that computes its own score; always available."""


def is_outside(name: str) -> bool:
    """Return whether a plugin's name refers to a user's code outside any package."""
    return name.startswith(PYTHON) and name != SCORE


_SENT = "<dynamic-code>"
"""The file name that cloudpickle, since 3.1.3, gives to code that it sends to a worker."""


@dataclass(frozen=True)
class PythonEntry(Entry):
    """A function or class that a user passed in Python.

    Attributes:
        model: plugin class of the function or class; None if it is not registered in this process.
        file: path of the file that contains the code; '' if unknown.
    """

    model: "type[Plugin] | None" = field(default=None, repr=False, compare=False)
    file: str = field(default="", repr=False, compare=False)

    @property
    def label(self) -> str:
        """The name of the function or class."""
        return python_name(self.name).removeprefix(PYTHON)

    @property
    def argument(self) -> str:
        """The argument that passes it to `gs.evolve`, such as `fitness=forward`.

        A name from a file can be any text, even code that a reader would paste and run. The
        argument therefore contains only an identifier.
        """
        usable = self.label.isidentifier() and not iskeyword(self.label)
        value = self.label if usable else "…"
        return f"{ARGUMENTS.get(self.kind, self.kind)}={value}"

    @property
    def remedy(self) -> str:
        """The remedy for a violation of its contract."""
        return f"correct {self.label}"

    def __str__(self) -> str:
        return f"Python {ARGUMENTS.get(self.kind, self.kind)} {self.label!r}"

    def place_of(self, error: BaseException) -> str:
        """Return the file and the innermost line of its code in the traceback of an error."""
        place, at = self.target, error.__traceback__
        while at is not None:
            if at.tb_frame.f_code.co_filename in (self.file, _SENT):
                place = f"{self.file}, line {at.tb_lineno}"
            at = at.tb_next
        return place

    @property
    def notice(self) -> str:
        """A warning for readers of the experiment, one sentence."""
        return f"The {self} is code outside the run: the run's files alone cannot reproduce it"

    @property
    def missing_error(self) -> MissingFunctionError:
        """The error to raise if it is used without being registered in this process."""
        space = ", space=…" if self.kind == "organism" else ""
        note = " (space only if the body is a function)" if space else ""
        return MissingFunctionError(
            f"the {self} is not stored in the experiment's file and must be passed again",
            where=f"{self.kind}.plugin = {self.name!a}",
            remedy=f"in Python, gs.load(RUN, {self.argument}{space}) or "
            f"gs.evolve(…, {self.argument}{space}){note}",
        )


_registered: dict[tuple[str, str], PythonEntry] = {}


def register(entry: PythonEntry) -> None:
    """Register an entry in this process; it replaces an earlier entry of the same name."""
    _registered[entry.kind, entry.name] = entry


def python_name(name: str) -> str:
    """Return the name of a Python function; older versions appended a checksum, `@1a2b3c4d`."""
    return name.partition("@")[0] if name.startswith(PYTHON) else name


def find_registered(kind: str, name: str) -> PythonEntry:
    """Return the entry of a `python:` name; its model is None if the name is not registered."""
    if (kind, name) == ("fitness", SCORE):
        return PythonEntry(kind, name, "gaitsim", "gaitsim", "")
    found = _registered.get((kind, python_name(name)))
    return replace(found or PythonEntry(kind, name, "Python", OUTSIDE, ""), name=name)
