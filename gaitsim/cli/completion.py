"""Names that a shell completes: runs in `runs/`, presets, studies and plugins."""

import re
from collections.abc import Iterable

from gaitsim.errors import GaitsimError
from gaitsim.registry import EXPERIMENTS, KINDS, STUDIES, entries

# The completion scripts of bash and zsh expand what they are given, and anybody's folder may have
# any name: those with spaces, quotes, `$` or `*` are left out.
_SAFE = re.compile(r"\w[\w.+-]*")


def run_names(incomplete: str) -> list[str]:
    """Return the names of runs in `runs/` that begin with a text, oldest first."""
    from gaitsim.runs.files.folder import RUNS, list_runs

    try:
        found = list_runs(RUNS)
    except GaitsimError:  # `runs` is a file or may not be read; the command itself reports it
        return []
    return _matching(incomplete, (run.name for run in found))


def preset_names(incomplete: str) -> list[str]:
    """Return the names of presets that begin with a text."""
    return _matching(incomplete, entries(EXPERIMENTS))


def study_names(incomplete: str) -> list[str]:
    """Return the names of installed studies that begin with a text."""
    return _matching(incomplete, entries(STUDIES))


def plugin_names(incomplete: str) -> list[str]:
    """Return the names of plugins of all kinds that begin with a text; import none of them."""
    return _matching(incomplete, sorted({name for kind in KINDS for name in entries(kind)}))


def _matching(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete) and _SAFE.fullmatch(name)]
