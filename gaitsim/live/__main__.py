"""`python -m gaitsim.live RUN`: evolve a run under the commands of standard input."""

import argparse
import signal
import sys
from functools import partial
from pathlib import Path

from gaitsim.live.protocol import Command
from gaitsim.live.stdio import isolate_stdio, lines, write_all


def main() -> int:
    """Evolve; return 2 where that failed."""
    parser = argparse.ArgumentParser("python -m gaitsim.live", allow_abbrev=False)
    parser.add_argument("run", type=Path)
    parser.add_argument("--generations", type=int)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    parser.add_argument("--paused", action="store_true")
    parser.add_argument("--any-version", action="store_true")
    given = parser.parse_args()

    # First, as the controlling process may end it before the libraries are loaded.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    source, sink = isolate_stdio()
    from gaitsim.live.commands import CommandQueue
    from gaitsim.live.reporter import Reporter

    commands = CommandQueue(paused=given.paused)

    def stop(*_: object) -> None:
        commands.add(Command("stop"))

    signal.signal(signal.SIGTERM, stop)
    commands.listen(lines(source))
    reporter = Reporter(partial(write_all, sink), lost=stop)
    from gaitsim.errors import GaitsimError
    from gaitsim.experiment import parse_assignments
    from gaitsim.live.session import evolve_live

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
    return 2 if state == "failed" else 0


if __name__ == "__main__":
    sys.exit(main())
