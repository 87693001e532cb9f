"""Names for shell completion: runs in `runs/`, tags, presets, studies and plugins."""

import re
from collections.abc import Iterable
from contextlib import suppress

from gaitsim.errors import GaitsimError
from gaitsim.registry import EXPERIMENTS, PLUGINS, STUDIES, entries

# The completion scripts of bash and zsh expand their input, so names with spaces, quotes, `$` or
# `*`, which a folder may have, are left out.
_SAFE = re.compile(r"\w[\w.+-]*")


def run_names(incomplete: str) -> list[str]:
    """Return the names of runs in `runs/` with this prefix, oldest first."""
    from gaitsim.storage.files.folder import RUNS, list_runs

    try:
        found = list_runs(RUNS)
    except GaitsimError:  # `runs` is not a readable folder; the command itself reports it
        return []
    return _matching(incomplete, (run.name for run in found))


def trash_names(incomplete: str) -> list[str]:
    """Return the names of runs in the trash of `runs/` with this prefix, latest first."""
    from gaitsim.storage.files.folder import RUNS
    from gaitsim.storage.manage import list_trash

    with suppress(GaitsimError):
        return _matching(incomplete, dict.fromkeys(run.name for run in list_trash(RUNS)))
    return []


def tag_names(incomplete: str) -> list[str]:
    """Return the tags of runs in `runs/` with this prefix."""
    from gaitsim.storage.files.folder import RUNS, list_runs
    from gaitsim.storage.manage import read_tags

    found: set[str] = set()
    with suppress(GaitsimError):
        for run in list_runs(RUNS):
            with suppress(GaitsimError):
                found.update(read_tags(run))
    return _matching(incomplete, sorted(found))


def query_keys(incomplete: str) -> list[str]:
    """Return the keys of queries with this prefix."""
    from gaitsim.storage.query import KEYS

    return _matching(incomplete, KEYS)


def preset_names(incomplete: str) -> list[str]:
    """Return the names of presets with this prefix."""
    return _matching(incomplete, entries(EXPERIMENTS))


def preset_or_run_names(incomplete: str) -> list[str]:
    """Return the names of presets, then of runs, with this prefix."""
    return list(dict.fromkeys([*preset_names(incomplete), *run_names(incomplete)]))


def study_names(incomplete: str) -> list[str]:
    """Return the names of installed studies with this prefix."""
    return _matching(incomplete, entries(STUDIES))


def plot_kinds(incomplete: str) -> list[str]:
    """Return the kinds of plots with this prefix."""
    return _matching(incomplete, [*entries("plot"), "all"])


def export_formats(incomplete: str) -> list[str]:
    """Return the formats of exports with this prefix."""
    return _matching(incomplete, entries("exporter"))


def plugin_names(incomplete: str) -> list[str]:
    """Return the names of plugins of all kinds with this prefix, without importing them."""
    known = {name for kind in PLUGINS for name in entries(kind)}
    return _matching(incomplete, sorted(known))


def _matching(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete) and _SAFE.fullmatch(name)]
