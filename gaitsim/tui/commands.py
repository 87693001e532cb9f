"""The command palette, which finds all actions by name or synonym."""

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

from textual.binding import Binding
from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.content import Content

from gaitsim.tui.keys import NAMED
from gaitsim.tui.screens.base import Dialog, GaitScreen, declared_keys, is_command, unavailable
from gaitsim.tui.themes import is_ours

DIM = 0.7  # factor on the scores of unavailable commands
SYNONYM = 0.9  # factor on the scores of synonyms
CLOSE_FIRST = "Close this dialog first (esc)."


class PaletteEntry(NamedTuple):
    """A command of the palette.

    Attributes:
        title: name of the command.
        about: one line of help, or the reason why it is unavailable.
        do: function to call; None if the command is unavailable.
        words: synonyms.
    """

    title: str
    about: str
    do: Callable[[], object] | None
    words: str = ""


class Commands(Provider):
    """The commands of the screen and the app, with the reasons why some are unavailable."""

    def _available(self) -> Iterator[PaletteEntry]:
        """Yield the available commands."""
        screen, app = self.screen, self.app
        seen: set[str] = set()
        for node, binding, enabled, tooltip in screen.active_bindings.values():
            if not enabled or not is_command(binding) or binding.id in seen:
                continue
            seen.add(binding.id or "")
            about = f"{tooltip or binding.tooltip}  ({app.get_key_display(binding)})"
            yield PaletteEntry(
                binding.description,
                about.strip(),
                partial(app.run_action, binding.action, default_namespace=node),
                NAMED[binding.id or ""].synonyms,
            )
        if isinstance(screen, GaitScreen | Dialog):
            titles = {NAMED[name].label for name in seen}
            for title, about, do in screen.palette():
                if title not in titles:  # not a button with the name of an action
                    yield PaletteEntry(title, about, do)

    def _unavailable(self, titles: set[str]) -> Iterator[PaletteEntry]:
        """Yield unavailable commands with their reasons, except those with one of the titles."""
        titles, screen = {*titles}, self.screen
        if isinstance(screen, Dialog):
            stack = self.app.screen_stack
            below = stack[stack.index(screen) - 1]
            for binding in (*declared_keys(self.app), *declared_keys(below)):
                if binding.description not in titles:
                    titles.add(binding.description)
                    words = NAMED[binding.id or ""].synonyms
                    yield PaletteEntry(binding.description, CLOSE_FIRST, None, words)
            return
        if not isinstance(screen, GaitScreen):
            return
        for binding, reason in unavailable(screen, titles):
            titles.add(binding.description)
            words = NAMED[binding.id or ""].synonyms
            yield PaletteEntry(binding.description, reason, None, words)
        for action in NAMED.values():
            title = action.title or action.label
            if action.where and title not in titles:
                key = self.app.get_key_display(Binding(action.keys.partition(",")[0], ""))
                yield PaletteEntry(title, f"{action.where} press {key}.", None, action.synonyms)

    async def discover(self) -> Hits:
        """Yield all available commands while the query is empty."""
        for title, about, do, _ in self._available():
            if do is not None:
                yield DiscoveryHit(Content(title), do, title, escape_markup(about))

    async def search(self, query: str) -> Hits:
        """Yield the commands that match the query, with unavailable ones dimmed."""
        available = [*self._available()]
        for command in (*available, *self._unavailable({command.title for command in available})):
            title, about, do, words = command
            matcher = self.matcher(query)
            by_title = matcher.match(title)
            score = max(by_title, SYNONYM * _score(query, f"{words} {about}"))
            if score <= 0:
                continue
            score += is_ours(title.removeprefix("Theme: "))  # before Textual's themes
            shown = matcher.highlight(escape_markup(title)) if by_title else Content(title)
            if do is None:
                explain = partial(self.app.notify, about, title=title, markup=False)
                yield Hit(DIM * score, shown.stylize("dim"), explain, title, escape_markup(about))
            else:
                yield Hit(score, shown, do, title, escape_markup(about))


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
