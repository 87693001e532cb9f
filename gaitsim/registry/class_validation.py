"""Validate the class attributes and options that a plugin class declares."""

from collections.abc import Mapping
from typing import Any

from gaitsim.contracts import Channel, GenomeSpace, Plugin

OPERATORS = ("selection", "crossover", "mutation")
"""The kinds of plugin that a search uses only if it declares them."""

PLUGIN = "plugin"
"""The key that names the plugin in a section of an experiment; no option can have that name."""


def problems(kind: str, plugin: type[Plugin]) -> list[str]:
    """Return the errors in a plugin class, one sentence each."""
    found = []
    if kind == "organism":
        channels = getattr(plugin, "channels", None)
        if not (
            isinstance(channels, Mapping)
            and _are_strings(channels.keys())
            and all(isinstance(channel, Channel) for channel in channels.values())
        ):
            found.append("channels must be a dict that maps the name of each channel to a Channel")
        elif (angles := channels.get("joint_angles")) and (
            angles.axes != ("frames", "joints") or angles.unit != "rad"
        ):
            found.append("joint_angles must be Channel(('frames', 'joints'), 'rad', …)")
    if kind == "fitness" and not _are_strings(getattr(plugin, "needs", None)):
        found.append("needs must be a tuple of channel names")
    if kind in ("search", "crossover", "mutation"):
        spaces = getattr(plugin, "spaces", None)
        if not (isinstance(spaces, tuple) and spaces and all(map(_is_space, spaces))):
            found.append("spaces must be a tuple of classes such as RealSpace and BitSpace")
    if kind == "search":
        operators: Any = getattr(plugin, "operators", None)
        if not (isinstance(operators, tuple) and {*operators} <= {*OPERATORS}):
            found.append(f"operators must be a tuple of names among {', '.join(OPERATORS)}")
    # A crossover declares `children` as an option or as a class attribute.
    if kind == "crossover" and "children" not in plugin.model_fields:
        children = getattr(plugin, "children", None)
        if not isinstance(children, int) or children not in (1, 2):
            found.append("children must be 1 or 2")
    if PLUGIN in plugin.model_fields:
        found.append(f"an option cannot be named {PLUGIN!r}: this key names the plugin in a file")
    return found


def _are_strings(names: Any) -> bool:
    if isinstance(names, str) or names is None:
        return False
    try:
        return all(isinstance(name, str) for name in names)
    except TypeError:
        return False


def _is_space(thing: object) -> bool:
    return isinstance(thing, type) and issubclass(thing, GenomeSpace)
