"""Plugins by name: installed packages' entry points, presets and options."""

from gaitsim.registry.entry_points import (
    EXPERIMENTS,
    KINDS,
    STUDIES,
    Entry,
    blame,
    containing,
    entries,
    find,
    load_class,
    load_entry,
    remembering,
    scan,
    unreadable,
)

__all__ = [
    "EXPERIMENTS",
    "KINDS",
    "STUDIES",
    "Entry",
    "blame",
    "containing",
    "entries",
    "find",
    "load_class",
    "load_entry",
    "remembering",
    "scan",
    "unreadable",
]
