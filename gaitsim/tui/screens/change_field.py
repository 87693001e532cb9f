"""The text field of the dialog for changes."""

from typing import Protocol, cast

from gaitsim.tui.actions import bindings
from gaitsim.tui.widgets.ordered_input import OrderedInput


class Dialog(Protocol):
    """The interface of the dialog for its field."""

    def enter(self) -> None: ...
    def to_options(self) -> None: ...
    def complete_or_leave(self) -> None: ...


class AssignmentsField(OrderedInput):
    """The field for typed changes."""

    BINDINGS = bindings("change field")

    @property
    def _dialog(self) -> Dialog:
        return cast(Dialog, self.screen)

    async def action_submit(self) -> None:
        self._dialog.enter()  # not deferred

    def action_options(self) -> None:
        self._dialog.to_options()

    def action_complete(self) -> None:
        self._dialog.complete_or_leave()
