"""The title bar of a screen, and the row of keys at its bottom."""

from collections.abc import Sequence
from contextlib import suppress
from itertools import groupby
from typing import ClassVar, NamedTuple

from rich.cells import cell_len
from textual import widgets
from textual.app import ComposeResult
from textual.binding import Binding
from textual.dom import NoScreen
from textual.events import Mount
from textual.widgets._footer import FooterKey
from textual.widgets._header import HeaderTitle

MORE = "More"
_NEVER_OMITTED = {"screen.back", "app.help", "app.quit"}  # keys that are never omitted
_LINE = 1  # cell before the key of the palette


class Header(widgets.Header):
    """A header that tolerates its screen being closed while it is mounted.

    Textual's header would not find its title, and the app would end with a traceback.
    """

    def on_mount(self, event: Mount) -> None:
        event.prevent_default()  # Textual's own
        for node in (self.app, self.screen):
            for attribute in ("title", "sub_title"):
                self.watch(node, attribute, self._show_title)

    def _show_title(self) -> None:
        with suppress(NoScreen):
            for title in self.query(HeaderTitle):
                title.update(self.format_title())


class Item(NamedTuple):
    """A key of the footer: its binding, displayed key, description, state and tooltip.

    Of two keys with the same description, such as `[` and `]`, only the last has a description.
    """

    binding: Binding
    key: str
    text: str
    enabled: bool
    tooltip: str

    @property
    def width(self) -> int:
        """The width in cells, including the gap to its neighbours."""
        return cell_len(self.key) + (cell_len(self.text) + 3 if self.text else 1)


def fit_items(items: Sequence[Item], palette: Item | None, width: int) -> list[Item]:
    """Return the items that fit a width, the palette's last.

    If some do not fit, the last ones are omitted. The key of the help, or else of the palette, is
    then labelled 'More', because the help and the palette list all keys.

    Args:
        items: items in the order of importance.
        palette: item of the command palette.
        width: width of the footer, cells.
    """
    ends = [] if palette is None else [palette]
    width -= _LINE * len(ends)
    if _width([*items, *ends]) <= width:
        return [*items, *ends]
    has_help = any(item.binding.id == "app.help" for item in items)
    kept = [_labelled_more(item) if item.binding.id == "app.help" else item for item in items]
    if not has_help:
        ends = [_labelled_more(end) for end in ends]
    while _width([*kept, *ends]) > width and (omitted := _least_important(kept)):
        # Keys that share a description are omitted together.
        kept = [
            item
            for item in kept
            if item.binding.description != omitted or item.binding.id in _NEVER_OMITTED
        ]
    if len(kept) == len(items) or _width([*kept, *ends]) > width:
        ends = [end._replace(text="") for end in ends]
    return [*kept, *ends]


def _least_important(items: Sequence[Item]) -> str:
    """Return the description of the last key that may be omitted."""
    others = (item for item in reversed(items) if item.binding.id not in _NEVER_OMITTED)
    return next((item.binding.description for item in others), "")


def _labelled_more(item: Item) -> Item:
    return item._replace(text=MORE)


def _width(items: Sequence[Item]) -> int:
    return sum(item.width for item in items)


class Footer(widgets.Footer):
    """A footer that shows keys in full, or omits them and refers to the help.

    It rebuilds its keys only if the offered or enabled keys have changed. Textual's footer does so
    whenever bindings are checked, such as after each change of the focus, which took a quarter of
    the processor time of the replay screen's tests.
    """

    DEFAULT_CSS: ClassVar[str] = """
    Footer FooterKey.-joined { padding-left: 1; }
    """

    _shown: list[Item] | None = None

    def _items(self) -> list[Item]:
        """Return the keys that fit."""
        active = self.screen.active_bindings
        chosen = {}
        for _, binding, enabled, tooltip in active.values():
            if binding.show and binding.action not in chosen:
                key = self.app.get_key_display(binding)
                about = tooltip or binding.tooltip
                chosen[binding.action] = Item(binding, key, binding.description, enabled, about)
        # The actions of packages, `on_…`, follow those of the screen; the app's come last.
        order = sorted(
            chosen.values(),
            key=lambda item: (
                (item.binding.id or "").startswith("app."),
                item.binding.action.startswith("on_"),
            ),
        )
        items: list[Item] = []
        for _, same in groupby(order, lambda item: item.text):
            *joined, last = same
            items += [item._replace(text="") for item in joined] + [last]
        if any(item.binding.id == "screen.back" for item in items):
            items = [item for item in items if item.binding.id != "app.quit"]
        palette = None
        if self.show_command_palette and self.app.COMMAND_PALETTE_BINDING in active:
            _, binding, enabled, _ = active[self.app.COMMAND_PALETTE_BINDING]
            key = self.app.get_key_display(binding)
            about = binding.tooltip or binding.description
            palette = Item(binding, key, binding.description, enabled, about)
        return fit_items(items, palette, self.app.size.width)

    def compose(self) -> ComposeResult:
        """Compose a widget for each offered key."""
        self._shown = None
        if not self._bindings_ready:
            return
        self._shown = self._items()
        for item in self._shown:
            palette = item.binding.key == self.app.COMMAND_PALETTE_BINDING
            key = FooterKey(
                item.binding.key,
                item.key,
                item.text,
                item.binding.action,
                disabled=not item.enabled,
                tooltip=item.tooltip or item.binding.description,
                classes="-command-palette" if palette else "" if item.text else "-joined",
            )
            yield key if palette else key.data_bind(compact=Footer.compact)

    async def recompose(self) -> None:
        """Rebuild the keys if they have changed, unless the screen has been closed."""
        if not self.is_attached or self.screen not in self.app.screen_stack:
            return
        if self._items() != self._shown or not self.children:
            await super().recompose()

    def on_resize(self) -> None:
        """Show as many keys as fit."""
        self.call_after_refresh(self.recompose)
