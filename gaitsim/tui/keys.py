"""All ids that a user can give keys to, over all screens, and what is wrong with what is given."""

import unicodedata
from collections.abc import Iterable, Iterator
from importlib import import_module
from itertools import combinations
from pkgutil import walk_packages
from string import punctuation
from typing import Any

from textual.app import App
from textual.binding import Binding
from textual.dom import DOMNode
from textual.keys import Keys, _normalize_key_list

import gaitsim.tui
from gaitsim.errors import GaitsimError
from gaitsim.tui.config import Config, check_keys, is_key

# What Textual replaces in the names that Unicode gives to signs.
_SIGNS = {"plus", "minus", "slash", "backslash", "at", "pound", "underscore"}
KEYS = (
    frozenset(key.value.rpartition("+")[2] for key in Keys)
    | {unicodedata.name(sign).lower().replace(" ", "_").replace("-", "_") for sign in punctuation}
    | _SIGNS
)


def usable(config: Config) -> dict[str, str]:
    """The keys of the settings that there are, by id; what has none of them keeps its own."""
    chosen = {
        name: [key.strip() for key in text.split(",") if is_key(key.strip(), KEYS)]
        for name, text in config.keys.items()
    }
    return {name: ",".join(keys) for name, keys in chosen.items() if keys}


def problems(config: Config) -> list[GaitsimError]:
    """What is wrong with the keys of the settings. Imports every screen: not before the paint."""
    for module in walk_packages(gaitsim.tui.__path__, "gaitsim.tui."):
        import_module(module.name)
    nodes = list(_all(DOMNode))
    ids = {binding.id for node in nodes for binding in _bindings(node)}
    return [*check_keys(config, ids, KEYS), *_clashes(config, nodes)]


def _clashes(config: Config, nodes: Iterable[type[DOMNode]]) -> list[GaitsimError]:
    """Keys of the settings that do something else on the same screen, which it does no longer."""
    found: dict[tuple[str, str], GaitsimError] = {}
    nodes, given = list(nodes), usable(config)
    apps = [binding for node in nodes if issubclass(node, App) for binding in _bindings(node)]
    for node in nodes:
        # What every screen has, and the app has on every screen, counts on each.
        own = [binding for kind in reversed(node.__mro__) for binding in _bindings(kind)]
        known = {binding.id: _keys(binding.key) for binding in [*apps, *own]}
        for one, other in combinations(sorted(known), 2):
            chosen = [_keys(given.get(name, "")) or known[name] for name in (one, other)]
            both = chosen[0] & chosen[1]
            # Those that share a key by default work in turn, as a pause and going on.
            if both and not known[one] & known[other]:
                found[one, other] = GaitsimError(
                    f"the key {min(both)} is given to {one} and to {other}",
                    where=f"{config.path}, section keys",
                    remedy="give one of them another key",
                )
    return list(found.values())


def _keys(text: str) -> set[str]:
    """The keys of a binding, a character by its name."""
    return set(_normalize_key_list(text).split(",")) - {""}


def _bindings(node: type) -> Iterator[Any]:
    """The bindings with ids that a class declares."""
    for binding in node.__dict__.get("BINDINGS", ()):
        if isinstance(binding, Binding) and binding.id:
            yield binding


def _all(kind: type[DOMNode]) -> Iterator[type[DOMNode]]:
    for known in kind.__subclasses__():
        if known.__module__.startswith("gaitsim.tui"):
            yield known
        yield from _all(known)
