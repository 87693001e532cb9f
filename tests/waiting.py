"""Wait for something to hold, with a limit; read what a widget shows."""

import asyncio
import time


def until(holds, seconds=60):
    """Wait until something holds."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


async def app_until(pilot, holds, seconds=60):
    """Wait until something holds in a running app, and until the app has settled.

    All widgets have their children then: one that is being mounted is found before it has any.
    """
    async with asyncio.timeout(seconds):
        while not (holds() and composed(pilot.app)):
            await pilot.pause(0.01)
    await pilot.pause()


def composed(app):
    """Return whether every widget on every screen has composed its children."""
    widgets = (one for screen in app.screen_stack for one in screen.walk_children(with_self=True))
    return all(one.is_mounted for one in widgets)


def strips(widget):
    """The rows that a widget shows."""
    return [widget.render_line(row) for row in range(widget.content_size.height)]
