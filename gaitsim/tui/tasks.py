"""Gaitsim commands that run in the background, each in its own process.

The UI runs commands that a user could also type, so it has no functions of its own.
Progress, files and errors arrive as records on standard error, one JSON object per line.
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
LONGEST = 1 << 20  # bytes of a line; longer lines are dropped
GRACE = 5.0  # seconds from the request to stop a process until it is killed

TaskState = Literal["running", "done", "failed", "stopped"]


@dataclass
class Task:
    """A command that runs, or ran, in the background.

    Attributes:
        arguments: arguments of `gaitsim`.
        started: start time on the monotonic clock, seconds.
        state: 'running', or how the task ended.
        progress: description of the current step.
        share: completed share of the step, 0 to 1; None while it is unknown.
        output: lines of standard output.
        notices: lines of standard error that are not records.
        files: files that the task wrote.
        error: reported error if the task failed; None for other failures.
        ended: end time on the monotonic clock, seconds.
        opens: whether to open the written file at the end.
        columns: width of the output's tables.
    """

    arguments: tuple[str, ...]
    started: float = field(default_factory=monotonic)
    state: TaskState = "running"
    progress: str = ""
    share: float | None = None
    output: list[str] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)
    error: GaitsimError | None = None
    ended: float | None = None
    opens: bool = False
    columns: int = 80

    @property
    def command(self) -> str:
        """The command line, quoted for a shell."""
        return shlex.join(["gaitsim", *self.arguments])

    @property
    def running(self) -> bool:
        """Whether the task is still running."""
        return self.state == "running"

    @property
    def message(self) -> str:
        """The reason why the task failed."""
        if self.error is not None:
            return visible_lines(str(self.error))
        return (
            "\n".join(self.notices[-8:] or self.output[:8]) or "the command ended without a message"
        )

    @property
    def seconds(self) -> float:
        """Duration so far, seconds."""
        return (self.ended or monotonic()) - self.started

    def add_output(self, line: str) -> None:
        """Store a line of standard output."""
        self.output.append(visible(line))
        del self.output[:-KEPT]

    def add_record(self, line: str) -> None:
        """Process a line of standard error: a record, or output of a library."""
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
                    self.share = min(1.0, done / total) if total else None
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
    """Posted when a task starts, progresses or ends; replaces earlier messages of the task."""

    task: Task

    def can_replace(self, message: Message) -> bool:
        """Return whether a waiting message is about the same task."""
        return isinstance(message, TaskChanged) and message.task is self.task


class Tasks:
    """The tasks of the app, the newest last.

    Args:
        on_change: function called with a task that started, progressed or ended.
    """

    def __init__(self, on_change: Callable[[Task], None]) -> None:
        self.all: list[Task] = []
        self._on_change = on_change
        self._processes: dict[int, asyncio.subprocess.Process] = {}
        self._running: set[asyncio.Task[None]] = set()

    def start(self, arguments: Sequence[str], *, opens: bool = False, columns: int = 80) -> Task:
        """Run a gaitsim command; with `opens`, open the file that it writes."""
        task = Task(tuple(arguments), opens=opens, columns=columns)
        self.all.append(task)
        job = asyncio.create_task(self._run(task))
        self._running.add(job)
        job.add_done_callback(self._running.discard)
        return task

    def stop(self, task: Task) -> None:
        """Ask a task to stop, as Ctrl-C does; the command removes partial files."""
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
        """Remove the tasks that have ended."""
        self.all = [task for task in self.all if task.running]

    async def _run(self, task: Task) -> None:
        self._on_change(task)
        try:
            code = await self._process(task)
        except OSError as error:
            task.notices.append(f"the command cannot be started: {error.strerror}")
            code = 1
        finally:
            self._processes.pop(id(task), None)
            task.ended = monotonic()
        if task.state == "running":
            task.state = "done" if code == 0 else "failed"
        self._on_change(task)

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
            env=_environment(task.columns),
            start_new_session=True,  # keeps Ctrl-C in the app's terminal from the task
        )
        self._processes[id(task)] = process
        readers = [
            asyncio.create_task(self._read(task, stream, add))
            for stream, add in (
                (process.stdout, task.add_output),
                (process.stderr, task.add_record),
            )
            if stream is not None
        ]
        code = await process.wait()
        # The last lines may still be in the pipes, which a remaining child may keep open.
        for reader in (await asyncio.wait(readers, timeout=1))[1]:
            reader.cancel()
        return code

    async def _read(
        self, task: Task, stream: asyncio.StreamReader, add: Callable[[str], None]
    ) -> None:
        while True:
            try:
                line = await stream.readline()
            except ValueError:  # line too long
                continue
            if not line:
                return
            add(line.decode(errors="replace").rstrip())
            self._on_change(task)


def _environment(columns: int) -> dict[str, str]:
    more = {"GAITSIM_PROGRESS": "json", "NO_COLOR": "1", "PYTHONUNBUFFERED": "1"}
    more["COLUMNS"] = str(columns)
    # The variables set by textual-serve are only for this process.
    return {k: v for k, v in os.environ.items() if not k.startswith("TEXTUAL")} | more
