"""The check of a plugin in the terminal UI."""

from typing import TYPE_CHECKING

from gaitsim.screen import Shown

if TYPE_CHECKING:
    from gaitsim.screen import GaitScreen


def _check(screen: "GaitScreen") -> None:
    screen.gaitsim.start_task(("plugins", "check", *screen.plugin))


CHECK = Shown(
    "check",
    "ctrl+k",
    "Check",
    "Check that the plugin fulfils its contract",
    on="plugin",
    show=_check,
)
