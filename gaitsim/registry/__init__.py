"""Plugins by name: the entry points of installed packages, presets and options."""

from gaitsim.registry.entry_points import (
    COMMANDS,
    EXPERIMENTS,
    FILES,
    KINDS,
    PLUGINS,
    PRODUCTS,
    REFLEX,
    STUDIES,
    Entry,
    contract_error,
    entries,
    find,
    plugin_context,
    plugin_errors,
    unreadable,
)
from gaitsim.registry.loading import call_reflex, load_class, load_entry, load_reflexes, scan

__all__ = [
    "COMMANDS",
    "EXPERIMENTS",
    "FILES",
    "KINDS",
    "PLUGINS",
    "PRODUCTS",
    "REFLEX",
    "STUDIES",
    "Entry",
    "call_reflex",
    "contract_error",
    "entries",
    "find",
    "load_class",
    "load_entry",
    "load_reflexes",
    "plugin_context",
    "plugin_errors",
    "scan",
    "unreadable",
]
