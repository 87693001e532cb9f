"""The keys that users assign to actions by ID, and problems of these assignments."""

import unicodedata
from collections.abc import Collection, Iterable, Iterator
from importlib import import_module
from itertools import combinations
from pkgutil import walk_packages
from string import punctuation
from typing import Any

from textual.app import App
from textual.binding import Binding
from textual.dom import DOMNode
from textual.keys import KEY_NAME_REPLACEMENTS, Keys

import gaitsim.tui
from gaitsim.errors import GaitsimError, nearest
from gaitsim.toml import literal
from gaitsim.tui.config import Config
from gaitsim.tui.vi import PREFIX

MODIFIERS = {"ctrl", "shift", "alt", "meta", "super", "hyper"}
KEYS = (
    frozenset(key.value.rpartition("+")[2] for key in Keys)
    | {unicodedata.name(sign).lower().replace(" ", "_").replace("-", "_") for sign in punctuation}
    | {*KEY_NAME_REPLACEMENTS.values()}
)


def valid_keys(config: Config) -> dict[str, str]:
    """Return the valid keys of the settings by ID; other IDs keep their default keys."""
    chosen = {
        name: [key.strip() for key in text.split(",") if is_key(key.strip())]
        for name, text in config.keys.items()
    }
    return {name: ",".join(keys) for name, keys in chosen.items() if keys}


def check_keys(config: Config, ids: Collection[str]) -> list[GaitsimError]:
    """Return the problems of the chosen keys, given the known IDs."""
    found = []
    for name, chosen in config.keys.items():
        place = {"where": f"{config.path}, key keys.{name}", "key": f"keys.{name}"}
        if name not in ids:
            remedy = nearest(name, sorted(ids)) or "press ? on a screen to list its IDs"
            found.append(GaitsimError(f"unknown ID {literal(name)}", remedy=remedy, **place))
        for key in chosen.split(","):
            if not is_key(key.strip()):
                bare = key.strip().rpartition("+")[2]
                found.append(
                    GaitsimError(
                        f"there is no key {literal(key.strip())}",
                        allowed='a character, or a name such as "enter", "f5" or "ctrl+d"',
                        remedy=nearest(bare, sorted(KEYS)),
                        **place,
                    )
                )
    return found


def is_key(key: str) -> bool:
    """Return whether a name is that of a key, such as 'x', 'enter' or 'ctrl+d'."""
    if len(key) == 1:
        return True
    *modifiers, bare = key.split("+")
    return {*modifiers} <= MODIFIERS and (len(bare) == 1 or bare in KEYS)


def find_problems(config: Config) -> list[GaitsimError]:
    """Return the problems of the keys in the settings; slow, because it imports every screen."""
    for module in walk_packages(gaitsim.tui.__path__, "gaitsim.tui."):
        import_module(module.name)
    nodes = list(_subclasses(DOMNode))
    ids = {binding.id for node in nodes for binding in _bindings(node)}
    return [*check_keys(config, ids), *_conflicts(config, nodes)]


def _conflicts(config: Config, nodes: Iterable[type[DOMNode]]) -> list[GaitsimError]:
    """Return the problems of keys that two actions of the same screen use."""
    found: dict[tuple[str, str], GaitsimError] = {}
    nodes, given = list(nodes), valid_keys(config)
    apps = [binding for node in nodes if issubclass(node, App) for binding in _bindings(node)]
    for node in nodes:
        # Keys of the base class and of the app exist on every screen.
        own = [binding for kind in reversed(node.__mro__) for binding in _bindings(kind)]
        known = {binding.id: _keys(binding.key) for binding in [*apps, *own]}
        for one, other in combinations(sorted(known), 2):
            chosen = [_keys(given.get(name, "")) or known[name] for name in (one, other)]
            # Keys of a screen override those of lists, unless the user chose the latter.
            yields = any(name.startswith(PREFIX) and name not in given for name in (one, other))
            both = set() if yields else chosen[0] & chosen[1]
            # Actions that share a key by default alternate, such as pause and go.
            if both and not known[one] & known[other]:
                found[one, other] = GaitsimError(
                    f"the key {min(both)} is assigned to {one} and to {other}",
                    where=f"{config.path}, section keys",
                    key="keys",
                    remedy="assign another key to one of them",
                )
    return list(found.values())


def _keys(text: str) -> set[str]:
    """Return the keys of a binding, with characters by name."""
    return {one.key for one in Binding.make_bindings([Binding(text, "")])} if text else set()


def _bindings(node: type) -> Iterator[Any]:
    """Yield the bindings with IDs that a class declares."""
    for binding in node.__dict__.get("BINDINGS", ()):
        if isinstance(binding, Binding) and binding.id:
            yield binding


def _subclasses(kind: type[DOMNode]) -> Iterator[type[DOMNode]]:
    for known in kind.__subclasses__():
        if known.__module__.startswith("gaitsim.tui"):
            yield known
        yield from _subclasses(known)
