"""Wait for a condition, with a timeout; read the content of a widget."""

import asyncio
import time


def until(holds, seconds=60):
    """Wait until a condition holds."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


async def app_until(pilot, holds, seconds=60):
    """Wait until a condition holds in a running app and all its widgets are composed.

    Queries also find widgets that are still being mounted and have no children yet.
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
    """Return the rows of a widget as shown."""
    return [widget.render_line(row) for row in range(widget.content_size.height)]
