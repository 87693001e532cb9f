"""Search the options of a new run by words, including those of plugins not chosen yet."""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple, Protocol, cast

from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.content import Content

from gaitsim.registry import KINDS, options
from gaitsim.registry.options import PLUGIN
from gaitsim.render.terminal.text import visible
from gaitsim.tui.builder import Validation
from gaitsim.tui.catalogue import Catalogue


class FoundOption(NamedTuple):
    """An option: its key, value and meaning, and its plugin if a different one is chosen."""

    key: str
    text: str
    meaning: str
    plugin: str = ""

    def score(self, query: str) -> float:
        """Return the score of a match, 0 to 1; 0 if a word of the query is missing."""
        words = query.casefold().split()
        key, rest = self.key.casefold(), f"{self.text} {self.plugin} {self.meaning}".casefold()
        if not all(word in key or word in rest for word in words):
            return 0.0
        named = sum(word in key for word in words) / max(1, len(words))
        exact = key.rpartition(".")[2] in words
        return (0.1 + 0.4 * named + 0.2 * exact) * (0.5 if self.plugin else 1.0)


def known_options(found: Validation, catalogue: Catalogue) -> Iterator[FoundOption]:
    """Yield the options of the experiment, then those of other plugins that work with its body."""
    for section, form in found.forms.items():
        if form.plugin:
            yield FoundOption(f"{section}.{PLUGIN}", form.plugin, form.about.split("\n")[0])
        for one in form.options:
            yield FoundOption(one.key, one.text, options.meaning(one.field))
    for kind in KINDS:
        for name in found.offered[kind]:
            if kind in found.forms and name != found.forms[kind].plugin:
                for option, field in catalogue.classes[kind][name].model_fields.items():
                    text = "" if field.is_required() else options.default(field)
                    yield FoundOption(f"{kind}.{option}", text, options.meaning(field), name)


class SearchedScreen(Protocol):
    """The interface of the searched screen."""

    validation: Validation | None
    catalogue: Catalogue | None

    def go_to(self, key: str, plugin: str = "") -> None: ...


class OptionSearch(Provider):
    """Options as entries of the palette; a chosen option gets the focus."""

    def _rows(self) -> Iterator[tuple[FoundOption, Content, str, partial[None]]]:
        screen = cast(SearchedScreen, self.screen)
        if screen.validation is None or screen.catalogue is None:
            return
        for one in known_options(screen.validation, screen.catalogue):
            title = f"{one.key}  {one.text}" + (f"  (plugin {one.plugin})" if one.plugin else "")
            go = partial(screen.go_to, one.key, one.plugin)
            yield one, Content(visible(title)), visible(one.meaning).replace("[", "\\["), go

    async def discover(self) -> Hits:
        """Yield the options of the experiment while the query is empty."""
        for one, title, about, go in self._rows():
            if not one.plugin:
                yield DiscoveryHit(title, go, title.plain, about)

    async def search(self, query: str) -> Hits:
        """Yield the options that contain all words of the query."""
        for one, title, about, go in self._rows():
            if (score := one.score(query)) > 0:
                yield Hit(score, title, go, title.plain, about)
