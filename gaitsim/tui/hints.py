"""Hints about useful keys, which disappear once the user knows them."""

import json
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.opening import read_regular
from gaitsim.storage.settings import user_folder

LEARNT = 2  # uses after which an action is known
SHOWN = 2  # maximum number of hints at a time
LARGEST = 100_000  # bytes
HINTED = (
    "home.new", "home.open", "home.replay", "home.export", "home.filter", "home.mark",
    "live.go", "live.pause", "live.change", "live.replay", "live.why", "live.fork", "live.export",
    "replay.pause", "replay.view", "replay.generation-back", "replay.split", "replay.why",
    "replay.export", "map.replay", "compare.quantity", "lab.adapt", "why.physics",
    "new.run", "new.search", "new.preset", "plugins.new", "studies.new", "app.help",
)  # fmt: skip
"""IDs of the actions with hints, the most useful first."""


def state_path() -> Path:
    """Return the path of the counts in $XDG_STATE_HOME or ~/.local/state, existing or not."""
    return user_folder("XDG_STATE_HOME", ".local/state") / "keys.json"


class Hints:
    """How often the user has used each action; a file that cannot be used is ignored.

    Args:
        path: file with the counts.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            found = json.loads(read_regular(path, LARGEST, follow=True))
        except (OSError, ValueError, RecursionError):
            found = {}
        known = found if isinstance(found, dict) else {}
        self._uses = {name: int(known[name]) for name in HINTED if type(known.get(name)) is int}

    def is_needed(self, name: str) -> bool:
        """Return whether an action has a hint that the user still needs."""
        return name in HINTED and self._uses.get(name, 0) < LEARNT

    def count(self, name: str) -> bool:
        """Count a use of an action; return whether the counts have changed."""
        if not self.is_needed(name):
            return False
        self._uses[name] = self._uses.get(name, 0) + 1
        return True

    def save(self) -> None:
        """Write the counts."""
        from gaitsim.storage.files.atomic import write_bytes  # not before the first paint

        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            write_bytes(self._path, json.dumps(self._uses, indent=1).encode())
        except (OSError, GaitsimError):
            pass
