"""The command palette, which finds the actions of a screen by their names and explanations."""

import re
from collections.abc import Iterator
from functools import partial

from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.content import Content

from gaitsim.tui.screens.base import Dialog, GaitScreen, PaletteCommand, is_command, unavailable
from gaitsim.tui.themes import is_ours

DIM = 0.7  # factor on the scores of unavailable commands
EXPLAINED = 0.9  # factor on the scores of commands whose explanation matches


class Commands(Provider):
    """The commands of the screen and the app, with the reasons why some are unavailable."""

    def _available(self) -> Iterator[PaletteCommand]:
        """Yield the available commands."""
        screen, app = self.screen, self.app
        seen: set[str] = set()
        titles: set[str] = set()
        for node, binding, enabled, tooltip in screen.active_bindings.values():
            if not enabled or not is_command(binding) or binding.id in seen:
                continue
            seen.add(binding.id or "")
            titles.add(binding.description)
            about = f"{tooltip or binding.tooltip}  ({app.get_key_display(binding)})"
            do = partial(app.run_action, binding.action, default_namespace=node)
            yield PaletteCommand(binding.description, about.strip(), do)
        if isinstance(screen, GaitScreen | Dialog):
            # Not a button with the name of an action.
            yield from (one for one in screen.palette() if one.title not in titles)

    async def discover(self) -> Hits:
        """Yield all available commands while the query is empty."""
        for title, about, do in self._available():
            yield DiscoveryHit(Content(title), do, title, escape_markup(about))

    async def search(self, query: str) -> Hits:
        """Yield the commands that match the query, with unavailable ones dimmed."""
        matcher, titles = self.matcher(query), set[str]()
        for title, about, do in self._available():
            titles.add(title)
            by_title = matcher.match(title)
            score = max(by_title, EXPLAINED * _score(query, about))
            if score > 0:
                score += is_ours(title.removeprefix("Theme: "))  # before Textual's themes
                shown = matcher.highlight(escape_markup(title)) if by_title else Content(title)
                yield Hit(score, shown, do, title, escape_markup(about))
        if not isinstance(self.screen, GaitScreen):
            return
        for binding, reason in unavailable(self.screen, titles):
            title = binding.description
            score = max(matcher.match(title), EXPLAINED * _score(query, binding.tooltip))
            if score > 0:
                explain = partial(self.app.notify, reason, title=title, markup=False)
                shown = Content(title).stylize("dim")
                yield Hit(DIM * score, shown, explain, title, escape_markup(reason))


def escape_markup(text: str) -> str:
    """Escape a string for the palette, which interprets markup."""
    return text.replace("[", "\\[")


def _score(query: str, text: str) -> float:
    """Return the score of a query if each of its words begins a word of a text, else 0.

    The score equals that of Textual's matcher for a title that contains the query.
    """
    wanted, words = query.casefold().split(), {*re.findall(r"\w+", text.casefold())}
    if not wanted or not all(any(word.startswith(one) for word in words) for one in wanted):
        return 0.0
    return 2 * (len(query) + 1) * (2.0 if words.issuperset(wanted) else 1.5)
