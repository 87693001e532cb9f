"""The command palette: everything that can be done now, by name."""

from collections.abc import Iterator
from functools import partial

from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.content import Content

from gaitsim.tui.screens.base import GaitScreen, PaletteCommand


class Commands(Provider):
    """The keys that work now, the commands of the screen, and those of the app."""

    def _commands(self) -> Iterator[PaletteCommand]:
        screen, app = self.screen, self.app
        met: set[str] = set()
        for node, binding, enabled, tooltip in screen.active_bindings.values():
            # Keys without a description, such as arrows and tab, are not commands.
            if not (enabled and binding.id and binding.description) or binding.id in met:
                continue
            met.add(binding.id)
            about = f"{tooltip or binding.tooltip}  ({app.get_key_display(binding)})"
            yield PaletteCommand(
                binding.description,
                about.strip(),
                partial(app.run_action, binding.action, default_namespace=node),
            )
        if isinstance(screen, GaitScreen):
            yield from screen.palette()
            yield from screen.gaitsim.palette()

    async def discover(self) -> Hits:
        """Yield all commands, while nothing is typed."""
        for title, about, do in self._commands():
            yield DiscoveryHit(Content(title), do, title, unmarked(about))

    async def search(self, query: str) -> Hits:
        """Yield the commands that match the query."""
        matcher = self.matcher(query)
        for title, about, do in self._commands():
            score = matcher.match(title)
            if score > 0:
                shown = matcher.highlight(unmarked(title))
                yield Hit(score, shown, do, title, unmarked(about))


def unmarked(text: str) -> str:
    """Escape a text for the palette, which reads markup."""
    return text.replace("[", "\\[")
