"""`gaitsim attach`."""

import asyncio
import sys

from gaitsim.cli.options import Json, RunName
from gaitsim.console import INTERRUPTED
from gaitsim.console.printing import notice
from gaitsim.runs.files.folder import command


def attach(run: RunName, json: Json = False) -> None:
    """Watch a run that is evolving in the background or in another program.

    Ctrl-C stops watching; the run continues.

    [bold]Examples[/bold]

    gaitsim run spider --detach --out runs/night

    gaitsim attach night

    gaitsim attach night --json > log.jsonl
    """
    from gaitsim.cli.evolving import find_evolving, follow_run, not_evolving
    from gaitsim.cli.run_view import summarise
    from gaitsim.runs.lock import is_locked

    found = find_evolving(run)
    path, in_background = found.path, found.process is not None
    if not in_background and not is_locked(path):
        raise not_evolving(found)
    last = asyncio.run(follow_run(path, json, in_background=in_background))
    match last.state:
        case "finished":
            summarise(found.reopened(), last.reason, json)
        case "stopped":
            notice(f"Stopped and saved. Continue with: {command('resume', path)}")
            sys.exit(INTERRUPTED)
        case "failed" if last.error is not None:
            raise last.error
        case _:
            stop = f" Stop it: {command('stop', path)}." if in_background else ""
            notice(f"{path} is still evolving.{stop} Watch it again: {command('attach', path)}")
            sys.exit(INTERRUPTED)
