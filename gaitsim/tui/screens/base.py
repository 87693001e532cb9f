"""What all screens share."""

from typing import TYPE_CHECKING, ClassVar, cast

from textual.screen import Screen

if TYPE_CHECKING:
    from gaitsim.tui.app import GaitsimApp


class GaitScreen(Screen[None]):
    """A screen with a help text; its keys have ids, so that users can choose others.

    Attributes:
        HELP_TEXT: what the screen is for and how it is used, in Markdown.
    """

    HELP_TEXT: ClassVar[str] = ""

    @property
    def gaitsim(self) -> "GaitsimApp":
        """The app, as what it is."""
        return cast("GaitsimApp", self.app)
