"""Gaitsim commands that run in the background, as processes of their own.

The UI runs the command that a user could type, so it can do nothing that the command line
cannot. Its progress, files and errors arrive as records, one JSON object a line on its standard
error.
"""

import asyncio
import json
import os
import shlex
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import Literal

from textual.message import Message

from gaitsim.errors import GaitsimError, error_from_dict
from gaitsim.render.terminal.text import visible, visible_lines

KEPT = 2000  # lines of output
LONGEST = 1 << 20  # bytes of a line; a longer one is dropped
GRACE = 5.0  # seconds between asking a process to stop and killing it

State = Literal["running", "done", "failed", "stopped"]


@dataclass
class Task:
    """A command that runs, or ran, in the background.

    Attributes:
        arguments: of `gaitsim`.
        began: when, by the monotonic clock.
        state: whether it runs, and how it ended.
        progress: what it works on.
        part: the part of that which is done, 0 to 1; None while that is unknown.
        output: the lines that it printed.
        notices: the lines that it printed beside its output.
        files: those that it wrote.
        error: why it failed, where it was the user's mistake.
        ended: when it ended, by the monotonic clock.
        opens: whether the file that it writes is opened when it is done.
    """

    arguments: tuple[str, ...]
    began: float = field(default_factory=monotonic)
    state: State = "running"
    progress: str = ""
    part: float | None = None
    output: list[str] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)
    error: GaitsimError | None = None
    ended: float | None = None
    opens: bool = False

    @property
    def command(self) -> str:
        """The command line, as a shell takes it."""
        return shlex.join(["gaitsim", *self.arguments])

    @property
    def running(self) -> bool:
        """Whether it still runs."""
        return self.state == "running"

    @property
    def message(self) -> str:
        """The reason why it failed."""
        if self.error is not None:
            return visible_lines(str(self.error))
        return "\n".join(self.notices[-8:] or self.output[:8]) or "it ended without a message"

    @property
    def seconds(self) -> float:
        """Its duration so far."""
        return (self.ended or monotonic()) - self.began

    def take_output(self, line: str) -> None:
        """Take a line of its output."""
        self.output.append(visible(line))
        del self.output[:-KEPT]

    def take_record(self, line: str) -> None:
        """Take a line of its standard error: a record, or a text that a library printed."""
        try:
            record = json.loads(line)
            match record:
                case {
                    "kind": "progress",
                    "what": str(what),
                    "done": int(done),
                    "total": int() | None as total,
                }:
                    self.progress = visible(what)
                    self.part = min(1.0, done / total) if total else None
                case {"kind": "result", "files": list(files)}:
                    self.files += map(Path, files)
                case {"kind": "error"}:
                    self.error = error_from_dict(record)
                case {"kind": "notice", "text": str(text)}:
                    self.notices += visible_lines(text).split("\n")
                case _:
                    self.notices.append(visible(line))
        except (ValueError, KeyError, TypeError):
            self.notices.append(visible(line))
        del self.notices[:-KEPT]


@dataclass
class TaskChanged(Message, bubble=False):
    """A task began, made progress, or ended; a later message of the same task replaces it."""

    task: Task

    def can_replace(self, message: Message) -> bool:
        """Return whether a waiting message is of the same task."""
        return isinstance(message, TaskChanged) and message.task is self.task


class Tasks:
    """The tasks of the app, the newest last.

    Args:
        changed: called with a task that began, made progress, or ended.
    """

    def __init__(self, changed: Callable[[Task], None]) -> None:
        self.all: list[Task] = []
        self._changed = changed
        self._processes: dict[int, asyncio.subprocess.Process] = {}
        self._running: set[asyncio.Task[None]] = set()

    def begin(self, arguments: Sequence[str], *, opens: bool = False) -> Task:
        """Run a gaitsim command; `opens` says whether the file that it writes is opened."""
        task = Task(tuple(arguments), opens=opens)
        self.all.append(task)
        job = asyncio.create_task(self._run(task))
        self._running.add(job)
        job.add_done_callback(self._running.discard)
        return task

    def stop(self, task: Task) -> None:
        """Ask a task to stop, as Ctrl-C does; the command removes what it has half written."""
        process = self._processes.get(id(task))
        if process is not None and process.returncode is None:
            task.state = "stopped"
            with suppress(ProcessLookupError):
                process.send_signal(signal.SIGINT)

    async def stop_all(self) -> None:
        """Stop every task and wait for them; kill those that do not stop."""
        for task in self.all:
            self.stop(task)
        if not await self.wait(GRACE):
            for process in self._processes.values():
                with suppress(ProcessLookupError):
                    process.kill()
            await self.wait(GRACE)

    async def wait(self, timeout: float | None = None) -> bool:
        """Wait until all tasks have ended; return whether they have."""
        return not self._running or not (await asyncio.wait({*self._running}, timeout=timeout))[1]

    def clear(self) -> None:
        """Forget the tasks that have ended."""
        self.all = [task for task in self.all if task.running]

    async def _run(self, task: Task) -> None:
        self._changed(task)
        try:
            code = await self._process(task)
        except OSError as error:
            task.notices.append(f"cannot start it: {error.strerror}")
            code = 1
        finally:
            self._processes.pop(id(task), None)
            task.ended = monotonic()
        if task.state == "running":
            task.state = "done" if code == 0 else "failed"
        self._changed(task)

    async def _process(self, task: Task) -> int:
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            "gaitsim",
            *task.arguments,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            limit=LONGEST,
            env=_environment(),
            start_new_session=True,  # Ctrl-C in the app's terminal is the app's
        )
        self._processes[id(task)] = process
        readers = [
            asyncio.create_task(self._read(task, stream, take))
            for stream, take in (
                (process.stdout, task.take_output),
                (process.stderr, task.take_record),
            )
            if stream is not None
        ]
        code = await process.wait()
        # Its last lines may still be on their way; a child that it left may hold the pipes.
        for reader in (await asyncio.wait(readers, timeout=1))[1]:
            reader.cancel()
        return code

    async def _read(
        self, task: Task, stream: asyncio.StreamReader, take: Callable[[str], None]
    ) -> None:
        while True:
            try:
                line = await stream.readline()
            except ValueError:  # too long
                continue
            if not line:
                return
            take(line.decode(errors="replace").rstrip())
            self._changed(task)


def _environment() -> dict[str, str]:
    more = {"GAITSIM_PROGRESS": "json", "NO_COLOR": "1", "PYTHONUNBUFFERED": "1"}
    # What textual-serve sets is meant for this process alone.
    return {k: v for k, v in os.environ.items() if not k.startswith("TEXTUAL")} | more
