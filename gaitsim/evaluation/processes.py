"""Tasks in worker processes of this machine."""

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
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from types import ModuleType
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.executors import MAX_ATTEMPTS, Executor, Result, Task, WorkerLostError
from gaitsim.registry.plugin_context import guard_process

OnWarning = Callable[[str], None]


class _Worker:
    """A worker process, started with this object, and the pipe to it."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs,))
        try:
            self._process.start()
        finally:
            theirs.close()

    def answer(self) -> tuple[bool, Any] | None:
        """Return whether the task succeeded, and its result or exception; None if it died."""
        try:
            answer: tuple[bool, Any] = self.pipe.recv()
        except (EOFError, OSError):
            return None
        return answer

    def end(self) -> None:
        """Kill the process, which may be busy or stopped; it holds nothing of value."""
        self._process.kill()
        self._process.join()
        self.pipe.close()


class ProcessExecutor(Executor):
    """Runs tasks in worker processes, which end with this one, however it ends.

    Args:
        workers: how many at most; each starts when there is work for it.
        on_warning: called with a message when a worker died.
    """

    def __init__(self, workers: int, on_warning: OnWarning = lambda text: None) -> None:
        self.workers = workers
        self._on_warning = on_warning
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, _Worker] = {}
        atexit.register(self.close)  # Python would wait for workers that nobody closed

    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Give each worker a task, and the next one when it has finished."""
        waiting = deque(range(len(tasks)))
        places: dict[_Worker, int] = {}
        deaths: Counter[int] = Counter()
        finished: list[tuple[int, Result]] = []
        while waiting or places:
            while waiting and len(self._busy) < self.workers:
                worker = self._submit(function, tasks[waiting[0]])
                if worker is not None:
                    places[worker] = waiting.popleft()
            yield from finished  # while the workers are busy again
            finished = []
            for worker, answer in self._answers():
                place = places.pop(worker, None)
                if place is None:  # a task that an earlier caller dropped
                    continue
                if answer is None:
                    deaths[place] += 1
                    if deaths[place] == MAX_ATTEMPTS:
                        raise WorkerLostError(
                            f"a worker process died {MAX_ATTEMPTS} times over the same work"
                        )
                    self._on_warning("a worker process died; another one repeats its work")
                    waiting.appendleft(place)
                    continue
                succeeded, result = answer
                if not succeeded:
                    raise result
                finished.append((place, result))
        yield from finished

    def _submit(self, function: Callable[[Task], Result], task: Task) -> _Worker | None:
        """Send a task to an idle worker, or to a new one; return None if that failed."""
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
            self._on_warning("a worker process died while it was idle; it is replaced")
            return None
        return worker

    def _start(self) -> bool:
        """Start a worker; return False after a warning if there are others, but no room for it."""
        try:
            # Ctrl-C comes before or after all of this, so that `close` knows of the worker.
            with hide_main_module(), block_signals():
                self._idle.append(_Worker())
        except OSError as error:  # such as too many open files
            if not self._busy:
                raise GaitsimError(
                    f"no worker process can start: {error}",
                    remedy="--workers 1 needs none; 'ulimit -n' and 'ulimit -u' show the limits",
                ) from None
            self.workers = len(self._busy)
            self._on_warning(f"no more than {self.workers} worker processes can start: {error}")
            return False
        return True

    def _answers(self) -> Iterator[tuple[_Worker, tuple[bool, Any] | None]]:
        """Wait for some answers; their workers are idle again, unless they died."""
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
    """Do tasks until the parent closes the pipe; the main function of a worker."""
    for number in (signal.SIGINT, signal.SIGTERM):  # for the parent to handle: it saves first
        signal.signal(number, signal.SIG_IGN)
    os.dup2(2, 1)  # what plugins print is no result
    guard_process()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, BrokenPipeError):  # the parent closed it
        while True:
            pipe.send_bytes(_answer(pipe.recv_bytes()))


def _answer(question: bytes) -> bytes:
    try:
        function, task = pickle.loads(question)
        return pickle.dumps((True, function(task)), pickle.HIGHEST_PROTOCOL)
    except BaseException as error:
        text = traceback.format_exc()
        error.add_note(text)
        try:
            return pickle.dumps((False, error))
        except Exception:
            return pickle.dumps((False, RuntimeError(text)))


def _end_with_parent() -> None:
    """End this worker when its parent is gone, which may have been killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class _MainModule:
    """The script that runs here; hidden as long as anyone wants it to be."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._users = 0
        self._module: ModuleType | None = None

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Keep processes that start in the block from importing the script.

        They need nothing of it, and would run whatever it does outside of
        `if __name__ == "__main__":`.
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

    A terminal sends Ctrl-C to all of them, before they could ignore it themselves.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # the first child would start it, which unblocks signals
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT, signal.SIGTERM])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
