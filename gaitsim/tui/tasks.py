"""What is made in the background: gaitsim commands as processes of their own, and how far they are.

The very command that a user could type runs, so the UI can do nothing that the command line
cannot. Its errors go to a pseudo-terminal where there is one, since progress is only drawn there.
"""

import asyncio
import os
import re
import shlex
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import Literal

WIDTH = 100  # columns of a progress line
KEPT = 2000  # lines of output
GRACE = 5.0  # seconds between asking a process to stop and making it

State = Literal["running", "done", "failed", "stopped"]
_ESCAPES = re.compile(r"\x1b\[[0-?]*[ -/]*[@-~]|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)|\x1b[@-_]")
_COUNT = re.compile(r"(\d[\d,]*)\s?/\s?(\d[\d,]*)")
_PERCENT = re.compile(r"(\d{1,3}) ?%")


@dataclass
class Task:
    """A command that runs, or ran, in the background.

    Attributes:
        arguments: of `gaitsim`.
        began: when, by the monotonic clock.
        state: how it stands.
        progress: the last line that says how far it is.
        part: the part of it that is done, 0 to 1; None where it does not say.
        output: what it printed, line by line.
        errors: what it said beside that: notices, and why it failed.
        ended: when it ended, by the monotonic clock.
    """

    arguments: tuple[str, ...]
    began: float = field(default_factory=monotonic)
    state: State = "running"
    progress: str = ""
    part: float | None = None
    output: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)
    ended: float | None = None

    @property
    def command(self) -> str:
        """As a shell takes it."""
        return shlex.join(["gaitsim", *self.arguments])

    @property
    def running(self) -> bool:
        """Whether it still does."""
        return self.state == "running"

    @property
    def result(self) -> str:
        """Its last line."""
        return self.output[-1] if self.output else ""

    @property
    def file(self) -> Path | None:
        """What it made, if its last line begins with the path of a file: 'a.mat: 300 frames'."""
        words = self.result.split(": ")
        paths = (": ".join(words[:end]) for end in range(len(words), 0, -1))
        # os.path, unlike pathlib, answers for names that no file can have, too.
        return next((Path(path) for path in paths if os.path.isfile(path)), None)  # noqa: PTH113

    @property
    def message(self) -> str:
        """Why it failed."""
        return "\n".join(self.errors[-8:]) or "it said nothing"

    @property
    def seconds(self) -> float:
        """How long it has taken."""
        return (self.ended or monotonic()) - self.began

    def take_progress(self, text: str) -> None:
        """Take what a program draws where it says how far it is; escapes are dropped."""
        lines = [line.strip() for line in re.split(r"[\r\n]+", clean(text)) if line.strip()]
        for line in lines:
            self.progress = line
            part = part_of(line)
            if part is not None:
                self.part = part
            elif not self.errors or self.errors[-1] != line:
                self.errors.append(line)
        del self.errors[:-KEPT]


def clean(text: str) -> str:
    """A text without what steers a terminal."""
    return "".join(char for char in _ESCAPES.sub("", text) if char in "\r\n" or char.isprintable())


def part_of(line: str) -> float | None:
    """How much of the work a line says is done, 0 to 1: by '3/10' or '30%'."""
    count = _COUNT.search(line)
    if count:
        done, total = (int(number.replace(",", "")) for number in count.groups())
        return min(1.0, done / total) if total else None
    percent = _PERCENT.search(line)
    return min(1.0, int(percent[1]) / 100) if percent else None


class Tasks:
    """The tasks of the app, the newest last.

    Args:
        changed: is told of a task when it has begun, come further, or ended.
    """

    def __init__(self, changed: Callable[[Task], None]) -> None:
        self.all: list[Task] = []
        self._changed = changed
        self._processes: dict[int, asyncio.subprocess.Process] = {}
        self._running: set[asyncio.Task[None]] = set()

    def begin(self, arguments: Sequence[str]) -> Task:
        """Run a gaitsim command."""
        task = Task(tuple(arguments))
        self.all.append(task)
        job = asyncio.create_task(self._run(task))
        self._running.add(job)
        job.add_done_callback(self._running.discard)
        return task

    def stop(self, task: Task) -> None:
        """Ask a task to stop, as Ctrl-C does; it removes what is half made."""
        process = self._processes.get(id(task))
        if process is not None and process.returncode is None:
            task.state = "stopped"
            with suppress(ProcessLookupError):
                process.send_signal(signal.SIGINT)

    async def stop_all(self) -> None:
        """Stop every task, and wait for them; who does not stop is ended."""
        for task in self.all:
            self.stop(task)
        if self._running:
            _, late = await asyncio.wait(set(self._running), timeout=GRACE)
            if late:
                for process in self._processes.values():
                    with suppress(ProcessLookupError):
                        process.kill()
                await asyncio.wait(late, timeout=GRACE)

    def clear(self) -> None:
        """Forget the tasks that have ended."""
        self.all = [task for task in self.all if task.running]

    async def _run(self, task: Task) -> None:
        self._changed(task)
        try:
            code = await self._process(task)
        except OSError as error:
            task.errors.append(f"cannot start it: {error.strerror}")
            code = 1
        finally:
            self._processes.pop(id(task), None)
            task.ended = monotonic()
        if task.state == "running":
            task.state = "done" if code == 0 else "failed"
        self._changed(task)

    async def _process(self, task: Task) -> int:
        screen, terminal = _terminal()
        try:
            process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-m",
                "gaitsim",
                *task.arguments,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.PIPE,
                stderr=terminal,
                env=_environment(),
                start_new_session=True,  # Ctrl-C in the app's terminal is the app's
            )
        finally:
            os.close(terminal)
        self._processes[id(task)] = process
        assert process.stdout is not None
        loop = asyncio.get_running_loop()
        heard = asyncio.Event()

        def hear() -> None:
            try:
                data = os.read(screen, 65536)
            except OSError:  # a pseudo-terminal's way to say that nobody writes any more
                data = b""
            if not data:
                loop.remove_reader(screen)
                heard.set()
                return
            task.take_progress(data.decode(errors="replace"))
            self._changed(task)

        loop.add_reader(screen, hear)
        try:
            async for line in process.stdout:
                task.output.append(clean(line.decode(errors="replace")).rstrip())
                del task.output[:-KEPT]
                self._changed(task)
            code = await process.wait()
            # What it said last may still be on its way; a child that it left may hold the line.
            with suppress(TimeoutError):
                await asyncio.wait_for(heard.wait(), timeout=1)
            return code
        finally:
            loop.remove_reader(screen)
            os.close(screen)


def _terminal() -> tuple[int, int]:
    """Two ends: one to read from, and one that programs take for a terminal, or a pipe."""
    try:
        import fcntl
        import pty
        import struct
        import termios
    except ImportError:
        return os.pipe()
    screen, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, WIDTH, 0, 0))
    return screen, terminal


def _environment() -> dict[str, str]:
    more = {"TERM": "xterm", "NO_COLOR": "1", "COLUMNS": str(WIDTH), "PYTHONUNBUFFERED": "1"}
    # What textual-serve sets is meant for this process alone.
    return {k: v for k, v in os.environ.items() if not k.startswith("TEXTUAL")} | more
