"""The text field of the dialog for changes."""

from typing import ClassVar, Protocol, cast

from textual.binding import Binding, BindingType

from gaitsim.tui.widgets.ordered_input import OrderedInput


class Dialog(Protocol):
    """The interface of the dialog for its field."""

    def enter(self) -> None: ...
    def to_options(self) -> None: ...
    def complete_or_leave(self) -> None: ...


class AssignmentsField(OrderedInput):
    """The field for typed changes."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("down", "options", "Options", show=False, id="change.options",
                tooltip="Go to the list of options"),
        Binding("tab", "complete", "Complete", show=False, id="change.complete",
                tooltip="Complete the typed word, or move to the next field"),
    ]  # fmt: skip

    @property
    def _dialog(self) -> Dialog:
        return cast(Dialog, self.screen)

    async def action_submit(self) -> None:
        self._dialog.enter()  # not deferred

    def action_options(self) -> None:
        self._dialog.to_options()

    def action_complete(self) -> None:
        self._dialog.complete_or_leave()
