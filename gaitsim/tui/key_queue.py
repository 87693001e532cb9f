"""Keys delivered one at a time: a dialog that a key opens receives the next key."""

import time
from collections import deque
from functools import partial
from typing import Any

from textual.app import App
from textual.events import Event, Key, Paste
from textual.message import Message
from textual.message_pump import MessagePump
from textual.worker import Worker, get_current_worker

ASKING = ("ask", "leaving")
"""Groups of workers that open a dialog or close a screen."""

PATIENCE = 2.0  # seconds to hold a key while a worker reads before it asks
LOST = 0.5  # seconds after which a widget that was removed no longer holds a key
_RETRY = 0.02  # seconds


class Settled(Message):
    """A message that follows a key through the same widgets, up to the app.

    Attributes:
        after: widget to follow once more, behind the messages that it posted for the key, such as
            that of Enter in a field; None the second time.
    """

    def __init__(self, after: MessagePump | None) -> None:
        super().__init__()
        self.after = after


class KeyQueue(App[None]):
    """An app that delivers each key or paste after all widgets have handled the one before.

    Textual sends a key to the widget that has the focus when the key arrives. If several keys
    arrive at once, the screen below a dialog would get the keys meant for the dialog.
    """

    def __init__(self) -> None:
        super().__init__()
        self._keys: deque[Key | Paste] = deque()
        self._settling: set[Settled] = set()
        self._answering: set[Worker[Any]] = set()
        self._held_since = 0.0
        self._retries = False

    @property
    def holds_keys(self) -> bool:
        """Whether a key waits to be delivered."""
        return bool(self._keys)

    async def on_event(self, event: Event) -> None:
        """Queue a key; handle other events at once."""
        if isinstance(event, Key | Paste) and not event.is_forwarded:
            if not self._keys:
                self._held_since = time.monotonic()
            self._keys.append(event)
            await self._deliver()
        else:
            await super().on_event(event)

    async def on_settled(self, event: Settled) -> None:
        await self._settle(event)

    async def _settle(self, event: Settled) -> None:
        if event in self._settling:
            self._settling.discard(event)
            if event.after is not None:
                self._wait_for(event.after, again=False)
        await self._deliver()

    async def _deliver(self) -> None:
        while self._keys and not self._settling and self.screen_stack:  # not at the end of the app
            if self._asks() and time.monotonic() - self._held_since < PATIENCE:
                if not self._retries:
                    self._retries = True
                    self.set_timer(_RETRY, self._retry)
                return
            event = self._keys.popleft()
            self._held_since = time.monotonic()
            target = self.focused or self.screen
            await super().on_event(event)
            self._wait_for(target)

    async def _retry(self) -> None:
        self._retries = False
        await self._deliver()

    def _asks(self) -> bool:
        """Return whether a worker is about to open or close a screen."""
        return any(
            worker.group in ASKING and not worker.is_finished and worker not in self._answering
            for worker in self.workers
        )

    def _wait_for(self, pump: MessagePump, *, again: bool = True) -> None:
        """Hold keys until a widget and its ancestors have handled their messages."""
        event = Settled(pump if again else None)
        if pump.post_message(event):
            self._settling.add(event)
            self.set_timer(LOST, partial(self._settle, event))

    def push_screen(self, screen: Any, *arguments: Any, **options: Any) -> Any:
        """Push a screen, which receives the next key."""
        if options.get("wait_for_dismiss"):
            self._answering.add(get_current_worker())
        pushed = super().push_screen(screen, *arguments, **options)
        self._wait_for(self.screen)
        return pushed

    async def push_screen_wait(self, screen: Any, **options: Any) -> Any:
        """Push a screen and wait for its result."""
        try:
            return await super().push_screen_wait(screen, **options)
        finally:
            self._answering.discard(get_current_worker())

    def pop_screen(self) -> Any:
        """Pop the current screen; the one below receives the next key."""
        popped = super().pop_screen()
        self._wait_for(self.screen)
        return popped
