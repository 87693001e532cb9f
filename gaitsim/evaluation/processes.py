"""Tasks in worker processes of this machine."""

import multiprocessing
import signal
import sys
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from types import ModuleType
from typing import cast

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.executors import MAX_ATTEMPTS, Executor, Result, Task, WorkerLostError
from gaitsim.evaluation.serialized import begin_worker

OnWarning = Callable[[str], None]


class ProcessExecutor(Executor):
    """In worker processes, which end with this one, however it ends.

    Each is a pool of its own: one that dies takes its own task with it and no other, and
    it is known which.

    Args:
        workers: how many at the most; each begins when there is work for it.
        on_warning: called with a message when a worker died.
    """

    def __init__(self, workers: int, on_warning: OnWarning = lambda text: None) -> None:
        self.workers = workers
        self._on_warning = on_warning
        self._pools: set[ProcessPoolExecutor] = set()
        self._idle: list[ProcessPoolExecutor] = []
        self._busy: dict[Future[object], ProcessPoolExecutor] = {}

    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Give each worker a task, and the next one when it is done with that."""
        waiting = deque(range(len(tasks)))
        places: dict[Future[object], int] = {}
        deaths: Counter[int] = Counter()
        try:
            while waiting or places:
                while waiting and len(self._busy) < self.workers:
                    future = self._submit(function, tasks[waiting[0]])
                    if future is not None:
                        places[future] = waiting.popleft()
                for future in self._done():
                    if future not in places:  # of work that was dropped before
                        continue
                    place = places.pop(future)
                    if _died(future):
                        deaths[place] += 1
                        self._bear(deaths[place])
                        waiting.appendleft(place)
                    else:
                        yield place, cast(Result, future.result())
        finally:
            for future in places:
                future.cancel()

    def _submit(self, function: Callable[[Task], Result], task: Task) -> Future[object] | None:
        """Hand a task to a worker that idles, or to a new one; None where neither could take it."""
        try:
            pool = self._idle.pop() if self._idle else self._pool()
            try:
                # Ctrl-C comes before or after all of this, so that `close` knows of the worker.
                with hide_main_module(), block_signals():
                    future: Future[object] = pool.submit(function, task)
                    self._busy[future] = pool
                return future
            except (OSError, RuntimeError):
                self._end(pool)
                raise
        except BrokenProcessPool:
            self._on_warning("a worker process died while it had nothing to do; it is replaced")
        except (OSError, RuntimeError) as error:  # of files or threads there are no more
            if not self._pools:
                raise GaitsimError(
                    f"no worker process can begin: {error}",
                    remedy="--workers 1 needs none; 'ulimit -n' and 'ulimit -u' tell the limits",
                ) from None
            self.workers = len(self._pools)
            self._on_warning(f"no more than {self.workers} worker processes can begin: {error}")
        return None

    def _pool(self) -> ProcessPoolExecutor:
        pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), begin_worker)
        self._pools.add(pool)
        return pool

    def _end(self, pool: ProcessPoolExecutor) -> None:
        self._pools.discard(pool)
        # A worker holds nothing, and one that was stopped would never hear of an end.
        for process in list((pool._processes or {}).values()):
            process.kill()
        pool.shutdown(cancel_futures=True)

    def _done(self) -> list[Future[object]]:
        """Wait for some; their workers are idle again, but for those that died."""
        done = list(wait(self._busy, return_when=FIRST_COMPLETED).done)
        for future in done:
            pool = self._busy.pop(future)
            if _died(future):
                self._end(pool)
            else:
                self._idle.append(pool)
        return done

    def _bear(self, deaths: int) -> None:
        if deaths == MAX_ATTEMPTS:
            raise WorkerLostError(f"a worker process died {deaths} times over the same work")
        self._on_warning("a worker process died; what it did is done again by another")

    def close(self) -> None:
        """Kill the workers, whatever they do."""
        for pool in list(self._pools):
            self._end(pool)


def _died(future: Future[object]) -> bool:
    return not future.cancelled() and isinstance(future.exception(), BrokenProcessPool)


class _Script:
    """The script that runs here, which is out of sight as long as anybody wants it to be."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._wishes = 0
        self._script: ModuleType | None = None

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Let a process that begins meanwhile not import the script.

        It needs nothing of it, and would do again what the script does where that is not
        under `if __name__ == "__main__":`.
        """
        with self._lock:
            if not self._wishes:
                self._script = sys.modules["__main__"]
                sys.modules["__main__"] = ModuleType("__main__")
            self._wishes += 1
        try:
            yield
        finally:
            with self._lock:
                self._wishes -= 1
                if not self._wishes and self._script is not None:
                    sys.modules["__main__"] = self._script


hide_main_module = _Script().hidden


@contextmanager
def block_signals() -> Iterator[None]:
    """Let a process that begins meanwhile never hear of Ctrl-C, which the terminal sends to all.

    `begin_worker` would come a tenth of a second late.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT, signal.SIGTERM])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
