"""`python -m gaitsim.live RUN`: evolve a run under the commands of another process."""

import argparse
import json
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsim.live.stdio import isolate_stdio, lines, write_all

if TYPE_CHECKING:
    from gaitsim.live.commands import CommandQueue
    from gaitsim.live.reporter import Reporter

Connection = tuple["CommandQueue", "Reporter"]


def main() -> int:
    """Evolve the run; return the exit code: 0, or 2 after an error."""
    parser = argparse.ArgumentParser("python -m gaitsim.live", allow_abbrev=False)
    parser.add_argument("run", type=Path)
    parser.add_argument("--listen", action="store_true")
    parser.add_argument("--generations", type=int)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    parser.add_argument("--paused", action="store_true")
    parser.add_argument("--any-version", action="store_true")
    arguments = parser.parse_args()

    # Done first, because Ctrl-C may arrive while libraries are imported.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if arguments.listen and os.fork() > 0:
        # The child is orphaned, so the program that started it need not wait for it.
        os._exit(0)
    from gaitsim.errors import GaitsimError
    from gaitsim.experiment import parse_assignments
    from gaitsim.live.session import evolve_live

    try:
        connect = _connect_socket if arguments.listen else _connect_stdio
        with connect(arguments.run, paused=arguments.paused) as (commands, reporter):
            try:
                overrides = parse_assignments(arguments.overrides)
            except GaitsimError as error:
                reporter.state("failed", error=error)
                return 2
            state = evolve_live(
                arguments.run,
                commands,
                reporter,
                overrides=overrides,
                generations=arguments.generations,
                workers=arguments.workers,
                any_version=arguments.any_version,
            )
    except GaitsimError as error:  # the socket cannot be opened
        print(json.dumps({"error": error.to_dict()}), flush=True)  # noqa: T201
        return 2
    return 2 if state == "failed" else 0


@contextmanager
def _connect_stdio(_run: Path, *, paused: bool) -> Iterator[Connection]:
    """Read commands from standard input until it ends, and report to standard output."""
    source, sink = isolate_stdio()
    from gaitsim.live.commands import CommandQueue
    from gaitsim.live.reporter import Reporter

    commands = CommandQueue(paused=paused)
    stop = _stop_on_sigterm(commands)
    commands.listen(lines(source))
    yield commands, Reporter(partial(write_all, sink), on_disconnect=stop)


@contextmanager
def _connect_socket(run: Path, *, paused: bool) -> Iterator[Connection]:
    """Accept commands from any client of a socket, and report to all clients."""
    from gaitsim.live.commands import CommandQueue
    from gaitsim.live.hub import Hub
    from gaitsim.live.presence import Presence
    from gaitsim.live.reporter import Reporter
    from gaitsim.live.slots import Slot, slot_count
    from gaitsim.runs.background import create_runtime_folder

    slot = Slot(create_runtime_folder(), slot_count())
    presence = Presence(run)
    commands = CommandQueue(paused=paused, slot=slot, check=presence.check)
    _stop_on_sigterm(commands)
    hub = Hub(presence.listener, commands, presence.maintain)
    reporter = Reporter(hub.write, on_state=presence.publish_state)
    hub.serve(reporter.full_snapshot)
    with suppress(OSError):  # the parent process has ended
        print(json.dumps({"pid": os.getpid()}), flush=True)  # noqa: T201
    presence.redirect()
    try:
        yield commands, reporter
    finally:
        slot.release()
        hub.close()


def _stop_on_sigterm(commands: "CommandQueue") -> Callable[[], None]:
    """Queue a `stop` on SIGTERM; return the function that queues it."""
    from gaitsim.live.protocol import Command

    def stop(*_: object) -> None:
        commands.add(Command("stop"))

    signal.signal(signal.SIGTERM, stop)
    return stop


if __name__ == "__main__":
    sys.exit(main())
