"""The row of keys at the foot of a screen."""

from textual import widgets
from textual.app import ComposeResult
from textual.binding import Binding


class Footer(widgets.Footer):
    """A footer that makes its keys again only if others are offered, or others are enabled.

    Textual's footer does so whenever the bindings are checked, as after each change of the focus;
    that was a quarter of the processor time of the replay screen's tests.
    """

    _shown: list[tuple[Binding, bool, str]] | None = None

    def _offered(self) -> list[tuple[Binding, bool, str]]:
        return [active[1:] for active in self.screen.active_bindings.values()]

    def compose(self) -> ComposeResult:
        """Make a widget for each key that is offered now."""
        self._shown = self._offered()
        yield from super().compose()

    async def recompose(self) -> None:
        """Make the keys again if these are others, unless its screen has been left."""
        if self.is_attached and (self._offered() != self._shown or not self.children):
            await super().recompose()
