"""The command palette: what can be done now, by name."""

from collections.abc import Iterator
from functools import partial

from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.content import Content

from gaitsim.tui.screens.base import GaitScreen, PaletteCommand


class Commands(Provider):
    """Every key that works now, what the screen adds, and what the app can do anywhere."""

    def _commands(self) -> Iterator[PaletteCommand]:
        screen, app = self.screen, self.app
        met: set[str] = set()
        for node, binding, enabled, tooltip in screen.active_bindings.values():
            # What has no words is for fingers: arrows, tab, and what a text field takes.
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
        """All of them, while nothing is typed."""
        for title, about, do in self._commands():
            yield DiscoveryHit(Content(title), do, title, unmarked(about))

    async def search(self, query: str) -> Hits:
        """Those that fit what is typed."""
        matcher = self.matcher(query)
        for title, about, do in self._commands():
            score = matcher.match(title)
            if score > 0:
                shown = matcher.highlight(unmarked(title))
                yield Hit(score, shown, do, title, unmarked(about))


def unmarked(text: str) -> str:
    """A text that the palette, which reads markup, shows as it is."""
    return text.replace("[", "\\[")
