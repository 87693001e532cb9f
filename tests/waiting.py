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
    """Wait until something holds in a running app, and until the app has settled."""
    async with asyncio.timeout(seconds):
        while not holds():
            await pilot.pause(0.01)
    await pilot.pause()


def strips(widget):
    """The rows that a widget shows."""
    return [widget.render_line(row) for row in range(widget.content_size.height)]
