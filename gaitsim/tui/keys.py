"""All ids that a user can give keys to, over all screens, and what is wrong with what is given."""

import unicodedata
from collections.abc import Iterator
from importlib import import_module
from pkgutil import walk_packages
from string import punctuation

from textual.binding import Binding
from textual.dom import DOMNode
from textual.keys import Keys

import gaitsim.tui
from gaitsim.errors import GaitsimError
from gaitsim.tui.config import Config, check_keys

# What Textual replaces in the names that Unicode gives to signs.
_SIGNS = {"plus", "minus", "slash", "backslash", "at", "pound", "underscore"}
KEYS = (
    frozenset(key.value.rpartition("+")[2] for key in Keys)
    | {unicodedata.name(sign).lower().replace(" ", "_").replace("-", "_") for sign in punctuation}
    | _SIGNS
)


def problems(config: Config) -> list[GaitsimError]:
    """What is wrong with the keys of the settings. Imports every screen: not before the paint."""
    return check_keys(config, ids(), KEYS)


def ids() -> set[str]:
    """The ids of all bindings of the app, its screens and widgets."""
    found = set()
    for module in walk_packages(gaitsim.tui.__path__, "gaitsim.tui."):
        import_module(module.name)
    for node in _all(DOMNode):
        for binding in node.__dict__.get("BINDINGS", ()):
            if isinstance(binding, Binding) and binding.id:
                found.add(binding.id)
    return found


def _all(kind: type[DOMNode]) -> Iterator[type[DOMNode]]:
    for known in kind.__subclasses__():
        if known.__module__.startswith("gaitsim.tui"):
            yield known
        yield from _all(known)
