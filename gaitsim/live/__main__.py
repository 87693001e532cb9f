"""`python -m gaitsim.live RUN`: evolve a run in the background, under the commands of clients."""

import argparse
import json
import os
import signal
import sys
from pathlib import Path


def main() -> int:
    """Evolve the run; return the exit code: 0, or 2 after an error."""
    parser = argparse.ArgumentParser("python -m gaitsim.live", allow_abbrev=False)
    parser.add_argument("run", type=Path)
    parser.add_argument("--generations", type=int)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    parser.add_argument("--paused", action="store_true")
    parser.add_argument("--any-version", action="store_true")
    arguments = parser.parse_args()

    # Done first, because Ctrl-C may arrive while libraries are imported.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if os.fork() > 0:
        # The child is orphaned, so the program that started it need not wait for it.
        os._exit(0)
    from gaitsim.errors import GaitsimError
    from gaitsim.experiment import parse_assignments
    from gaitsim.live.evolving import evolve_live
    from gaitsim.live.server import connect

    try:
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


if __name__ == "__main__":
    sys.exit(main())
