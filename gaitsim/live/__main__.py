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

Connected = tuple["CommandQueue", "Reporter"]


def main() -> int:
    """Evolve the run; return 0, or 2 if that failed."""
    parser = argparse.ArgumentParser("python -m gaitsim.live", allow_abbrev=False)
    parser.add_argument("run", type=Path)
    parser.add_argument("--listen", action="store_true")
    parser.add_argument("--generations", type=int)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    parser.add_argument("--paused", action="store_true")
    parser.add_argument("--any-version", action="store_true")
    given = parser.parse_args()

    # First, as Ctrl-C may arrive while the libraries are being loaded.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if given.listen and os.fork() > 0:
        # The child is orphaned, so the process that started it need not wait for it.
        os._exit(0)
    from gaitsim.errors import GaitsimError
    from gaitsim.experiment import parse_assignments
    from gaitsim.live.session import evolve_live

    try:
        connected = _on_socket if given.listen else _on_stdio
        with connected(given.run, paused=given.paused) as (commands, reporter):
            try:
                overrides = parse_assignments(given.overrides)
            except GaitsimError as error:
                reporter.state("failed", error=error)
                return 2
            state = evolve_live(
                given.run,
                commands,
                reporter,
                overrides=overrides,
                generations=given.generations,
                workers=given.workers,
                any_version=given.any_version,
            )
    except GaitsimError as error:  # the socket cannot be opened
        print(json.dumps({"error": error.to_dict()}), flush=True)  # noqa: T201
        return 2
    return 2 if state == "failed" else 0


@contextmanager
def _on_stdio(_run: Path, *, paused: bool) -> Iterator[Connected]:
    """Read commands from standard input until it ends, and report to standard output."""
    source, sink = isolate_stdio()
    from gaitsim.live.commands import CommandQueue
    from gaitsim.live.reporter import Reporter

    commands = CommandQueue(paused=paused)
    stop = _stop_on_sigterm(commands)
    commands.listen(lines(source))
    yield commands, Reporter(partial(write_all, sink), lost=stop)


@contextmanager
def _on_socket(run: Path, *, paused: bool) -> Iterator[Connected]:
    """Accept commands from any client of a socket, and report to all clients."""
    from gaitsim.live.commands import CommandQueue
    from gaitsim.live.hub import Hub
    from gaitsim.live.places import Place, places
    from gaitsim.live.presence import Presence
    from gaitsim.live.reporter import Reporter
    from gaitsim.runs.background import make_runtime_folder

    place = Place(make_runtime_folder(), places())
    presence = Presence(run)
    commands = CommandQueue(paused=paused, place=place, check=presence.check)
    _stop_on_sigterm(commands)
    hub = Hub(presence.listener, commands, presence.tend)
    reporter = Reporter(hub.write, on_state=presence.note)
    hub.serve(reporter.everything)
    with suppress(OSError):  # the parent process has ended
        print(json.dumps({"pid": os.getpid()}), flush=True)  # noqa: T201
    presence.redirect()
    try:
        yield commands, reporter
    finally:
        place.leave()
        hub.close()


def _stop_on_sigterm(commands: "CommandQueue") -> Callable[[], None]:
    from gaitsim.live.protocol import Command

    def stop(*_: object) -> None:
        commands.add(Command("stop"))

    signal.signal(signal.SIGTERM, stop)
    return stop


if __name__ == "__main__":
    sys.exit(main())
