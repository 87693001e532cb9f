"""Run tasks in worker processes on this machine."""

import atexit
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import traceback
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from types import ModuleType
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.executors import MAX_ATTEMPTS, Executor, Result, Task, WorkerLostError
from gaitsim.registry.entry_points import guard_process

OnWarning = Callable[[str], None]


class _Worker:
    """A worker process, started when the object is created, and the pipe to it."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs,))
        try:
            self._process.start()
        finally:
            theirs.close()

    def answer(self) -> tuple[bool, Any] | None:
        """Return (True, result) or (False, exception); None if the process died."""
        try:
            answer: tuple[bool, Any] = self.pipe.recv()
        except (EOFError, OSError):
            return None
        return answer

    def end(self) -> None:
        """Kill the process, even if it is busy or stopped; no data are lost."""
        self._process.kill()
        self._process.join()
        self.pipe.close()


class ProcessExecutor(Executor):
    """Runs tasks in worker processes, which always end together with this process.

    Args:
        workers: maximum number of worker processes; each starts when it is first needed.
        on_warning: called with a message when a worker died.
    """

    def __init__(self, workers: int, on_warning: OnWarning = lambda text: None) -> None:
        self.workers = workers
        self._on_warning = on_warning
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, _Worker] = {}
        atexit.register(self.close)  # otherwise Python waits for them when it exits

    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Run tasks; each worker gets the next task when it has finished one."""
        waiting = deque(range(len(tasks)))
        places: dict[_Worker, int] = {}
        deaths: Counter[int] = Counter()
        finished: list[tuple[int, Result]] = []
        while waiting or places:
            while waiting and len(self._busy) < self.workers:
                worker = self._submit(function, tasks[waiting[0]])
                if worker is not None:
                    places[worker] = waiting.popleft()
            yield from finished  # after the workers got new tasks
            finished = []
            for worker, answer in self._answers():
                place = places.pop(worker, None)
                if place is None:  # a task that an earlier caller dropped
                    continue
                if answer is None:
                    deaths[place] += 1
                    if deaths[place] == MAX_ATTEMPTS:
                        raise WorkerLostError(
                            f"a worker process died {MAX_ATTEMPTS} times on the same task"
                        )
                    self._on_warning("a worker process died; another one repeats its task")
                    waiting.appendleft(place)
                    continue
                succeeded, result = answer
                if not succeeded:
                    raise result
                finished.append((place, result))
        yield from finished

    def _submit(self, function: Callable[[Task], Result], task: Task) -> _Worker | None:
        """Send a task to an idle or new worker; return None if this failed."""
        if not self._idle and not self._start():
            return None
        worker = self._idle.pop()
        self._busy[worker.pipe] = worker
        try:
            worker.pipe.send((function, task))
        except BaseException as error:
            del self._busy[worker.pipe]
            worker.end()
            if not isinstance(error, OSError):
                raise
            self._on_warning("an idle worker process died; a new one replaces it")
            return None
        return worker

    def _start(self) -> bool:
        """Start a worker; if this fails while others are busy, warn and return False."""
        try:
            # With signals blocked, Ctrl-C cannot leave a worker that `close` does not know.
            with hide_main_module(), block_signals():
                self._idle.append(_Worker())
        except OSError as error:  # such as too many open files
            if not self._busy:
                raise GaitsimError(
                    f"cannot start a worker process: {error}",
                    remedy="try --workers 1, which starts no process, or check the limits with "
                    "'ulimit -n' and 'ulimit -u'",
                ) from None
            self.workers = len(self._busy)
            self._on_warning(f"cannot start more than {self.workers} worker processes: {error}")
            return False
        return True

    def _answers(self) -> Iterator[tuple[_Worker, tuple[bool, Any] | None]]:
        """Wait for one or more answers; mark their workers as idle unless they died."""
        ready = wait(self._busy)
        done = [self._busy.pop(pipe) for pipe in [*self._busy] if pipe in ready]
        answers = [(worker, worker.answer()) for worker in done]
        for worker, answer in answers:
            if answer is None:
                worker.end()
            else:
                self._idle.append(worker)
        yield from answers

    def close(self) -> None:
        """Kill the workers, busy or not."""
        atexit.unregister(self.close)
        for worker in [*self._idle, *self._busy.values()]:
            worker.end()
        self._idle.clear()
        self._busy.clear()


def _work(pipe: Connection) -> None:
    """Run tasks until the parent closes the pipe; the main function of a worker."""
    for number in (signal.SIGINT, signal.SIGTERM):  # the parent handles them: it saves first
        signal.signal(number, signal.SIG_IGN)
    os.dup2(2, 1)  # output of plugins must not mix with results on standard output
    guard_process()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, BrokenPipeError):  # the parent closed the pipe
        while True:
            pipe.send_bytes(_answer(pipe.recv_bytes()))


def _answer(request: bytes) -> bytes:
    try:
        function, task = pickle.loads(request)
        return pickle.dumps((True, function(task)), pickle.HIGHEST_PROTOCOL)
    except BaseException as error:
        text = traceback.format_exc()
        error.add_note(text)
        try:
            return pickle.dumps((False, error))
        except Exception:
            return pickle.dumps((False, RuntimeError(text)))


def _end_with_parent() -> None:
    """End this worker when its parent ends, even if the parent was killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class _MainModule:
    """The `__main__` module, replaced while any caller is in a `hidden` block."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._users = 0
        self._module: ModuleType | None = None

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Keep processes that start in the block from importing the main script.

        They do not need it, and would run all code outside `if __name__ == "__main__":`.
        """
        with self._lock:
            if not self._users:
                self._module = sys.modules["__main__"]
                sys.modules["__main__"] = ModuleType("__main__")
            self._users += 1
        try:
            yield
        finally:
            with self._lock:
                self._users -= 1
                if not self._users and self._module is not None:
                    sys.modules["__main__"] = self._module


hide_main_module = _MainModule().hidden


@contextmanager
def block_signals() -> Iterator[None]:
    """Block SIGINT and SIGTERM in child processes that start in the block.

    A terminal sends Ctrl-C to all processes, even before they can set their own handlers.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    with redirect_stderr(sys.__stderr__):  # the tracker inherits it; Textual's has no number
        resource_tracker.ensure_running()  # starting it with the first child would unblock signals
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT, signal.SIGTERM])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
