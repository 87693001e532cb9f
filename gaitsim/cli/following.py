"""Show a run that another process evolves, until it ends or the user stops watching."""

import asyncio
import signal
from collections.abc import AsyncIterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.cli.display import RESTING, Display, Row
from gaitsim.cli.progress import display
from gaitsim.console.printing import notice, output
from gaitsim.live.process import RunProcess
from gaitsim.live.protocol import Snapshot
from gaitsim.live.watcher import RunWatcher
from gaitsim.runs.growing import Rows
from gaitsim.runs.snapshot import RunSnapshot

INTEGER_COLUMNS = ("generation", "stage", "evaluations")


async def follow_run(path: Path, json: bool, *, in_background: bool) -> Snapshot:
    """Show a run until it ends or the user stops watching; return the last snapshot."""
    known = await asyncio.to_thread(RunWatcher(path).poll)
    process = RunProcess(path, initial=known, launch=False) if in_background else None
    follower = _Follower(path, display(path, known, json), known)
    following = asyncio.create_task(follower.follow(process or RunWatcher(path)))
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, following.cancel)
    await asyncio.wait([following])
    if process is not None:
        process.disconnect()
        await process.wait_ended()
    if not following.cancelled():
        following.result()
    return follower.last


class _Follower:
    """Shows the snapshots of a run, and each generation once.

    Args:
        path: folder of the run.
        shown: display that shows them.
        known: state of the run that the display already shows.

    Attributes:
        last: last snapshot shown.
    """

    def __init__(self, path: Path, shown: Display, known: Snapshot) -> None:
        self._path, self._shown = path, shown
        self._seen = known.generation
        self.last = known

    async def follow(self, snapshots: AsyncIterable[Snapshot]) -> None:
        """Show snapshots until the last one."""
        with self._shown:
            async for snapshot in snapshots:
                self._report(snapshot)
                rows = await asyncio.to_thread(self._rows, snapshot)
                self._shown.update(snapshot, rows)
                self.last = snapshot

    def _report(self, snapshot: Snapshot) -> None:
        before = self.last
        resting = snapshot.state != before.state and snapshot.state in RESTING
        if resting and not output().is_terminal:
            notice(RESTING[snapshot.state])
        if snapshot.error is not None and snapshot.state != "failed":
            self._shown.warn(str(snapshot.error))
        changes = [event for event in snapshot.events if event.kind == "stage"]
        if changes and snapshot.stage > before.stage:
            rescored = snapshot if snapshot.scored_from > before.scored_from else None
            texts = [event.text for event in changes]
            self._shown.start_stage(snapshot.stage, changes[0].generation, texts, rescored)

    def _rows(self, snapshot: Snapshot) -> Sequence[Row]:
        """Return the rows of the history that have not been shown.

        Rows that are needed from the run's folder but not yet there follow with a later snapshot.
        """
        rows, first = snapshot.rows, self._seen + 1
        # Only at rest, all rows are known to be in the folder.
        resting = snapshot.state in ("paused", "finished", "stopped")
        if snapshot.generation < first or not (rows or resting):
            return ()
        run = None
        if not rows or rows["generation"][0] > first:  # the snapshot left out earlier rows
            run = RunSnapshot(self._path)
            rows = run.history
        found = _as_dicts(rows, first) if rows else []
        if snapshot.islands and len(found) == 1 and first == snapshot.generation:
            found[0]["islands"] = list(snapshot.islands)
        elif snapshot.islands and found:
            bests = (run or RunSnapshot(self._path)).islands
            found = found[: max(len(bests) - self._seen, 0)]
            for one in found:
                one["islands"] = bests[one["generation"] - 1].tolist()
        self._seen += len(found)
        return found


def _as_dicts(rows: Rows, first: int) -> list[dict[str, Any]]:
    """Return the rows from generation `first`; a term that a row lacks is left out."""
    chosen = np.flatnonzero(rows["generation"] >= first)
    return [
        {
            name: int(values[index]) if name in INTEGER_COLUMNS else float(values[index])
            for name, values in rows.items()
        }
        for index in chosen
    ]
