"""`python -m gaitsim.live RUN`: evolve a run as standard input says; see the package."""

import argparse
import signal
import sys
from pathlib import Path

from gaitsim.live.protocol import Command
from gaitsim.live.stdio import claim, lines


def main() -> int:
    """Evolve; 2 where that failed."""
    parser = argparse.ArgumentParser("python -m gaitsim.live", allow_abbrev=False)
    parser.add_argument("run", type=Path)
    parser.add_argument("--generations", type=int)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    parser.add_argument("--paused", action="store_true")
    parser.add_argument("--any-version", action="store_true")
    given = parser.parse_args()

    # First, as whoever steers may end it before the libraries are loaded.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    commands, wire = claim()
    from gaitsim.live.commands import Wishes
    from gaitsim.live.reporter import Reporter

    wishes = Wishes(paused=given.paused)

    def stop(*_: object) -> None:
        wishes.add(Command("stop"))

    signal.signal(signal.SIGTERM, stop)
    wishes.listen(lines(commands))
    reporter = Reporter(wire, lost=stop)
    from gaitsim.errors import GaitsimError
    from gaitsim.experiment import parse_assignments
    from gaitsim.live.session import evolve_steered

    try:
        overrides = parse_assignments(given.overrides)
    except GaitsimError as error:
        reporter.state("failed", error=error)
        return 2
    state = evolve_steered(
        given.run,
        wishes,
        reporter,
        overrides=overrides,
        generations=given.generations,
        workers=given.workers,
        any_version=given.any_version,
    )
    return 2 if state == "failed" else 0


if __name__ == "__main__":
    sys.exit(main())
