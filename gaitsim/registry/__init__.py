"""Plugins by name: the entry points of installed packages, presets and options."""

from gaitsim.registry.entry_points import (
    COMMANDS as COMMANDS,
    ENGINES as ENGINES,
    EXPERIMENTS as EXPERIMENTS,
    FILES as FILES,
    FUNCTIONS as FUNCTIONS,
    KINDS as KINDS,
    PLUGINS as PLUGINS,
    PRODUCTS as PRODUCTS,
    REFLEX as REFLEX,
    SCREENS as SCREENS,
    STEER as STEER,
    STUDIES as STUDIES,
    VERIFIERS as VERIFIERS,
    Entry as Entry,
    contract_error as contract_error,
    entries as entries,
    find as find,
    plugin_context as plugin_context,
    plugin_errors as plugin_errors,
    unreadable as unreadable,
)
from gaitsim.registry.loading import (
    call_reflex as call_reflex,
    load_class as load_class,
    load_engine as load_engine,
    load_entry as load_entry,
    load_reflexes as load_reflexes,
    scan as scan,
)
