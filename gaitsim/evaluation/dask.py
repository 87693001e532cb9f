"""Tasks on a Dask cluster: an existing one, or one of our own on this machine."""

import logging
import re
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from gaitsim.errors import GaitsimError, not_installed
from gaitsim.evaluation.executors import (
    MAX_ATTEMPTS,
    Executor,
    Result,
    Task,
    WorkerLostError,
    cores,
)
from gaitsim.evaluation.packages import compare, finder, needed
from gaitsim.evaluation.processes import OnWarning, block_signals, hide_main_module
from gaitsim.experiment import Experiment

LOCAL = "local"
ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://.")
LOGGERS = ("distributed", "distributed.client")  # the second has a level of its own
SILENT = logging.CRITICAL + 1
PATIENCE = 10  # seconds for a scheduler to answer, and for its first worker to join
COUNT = 1.0  # seconds from a change among the workers until they are counted
ALONE = 5  # counts without any worker until a warning: one that died restarts within two


class DaskExecutor(Executor):
    """The workers of a Dask scheduler.

    A Dask cluster is trusted: scheduler and workers may run any code here, and this
    program may run any code there.

    Args:
        address: the scheduler's address, such as 'tcp://host:8786'; or 'local' for workers of
            our own on this machine, which end with this process, however it ends.
        workers: how many, with 'local'; None for one a core.
        on_warning: called with a message when workers were lost, and when none are left.

    Attributes:
        address: the scheduler's.
        workers: the current number of threads of its workers, which may come or go.

    Raises:
        GaitsimError: Dask is not installed, or the scheduler cannot be reached or has no
            workers, or `workers` is given beside an address.
    """

    def __init__(
        self, address: str, workers: int | None = None, on_warning: OnWarning = lambda text: None
    ) -> None:
        if workers is not None and address != LOCAL:
            raise GaitsimError(
                f"--workers {workers} and --dask {address} do not go together",
                allowed="--workers with --dask local; other clusters have a size of their own",
            )
        if address != LOCAL and not ADDRESS.match(address):
            raise _unreachable(address, "not an address")
        self.address = address
        self._on_warning = on_warning
        self._closing = False
        self._counting = False
        self._alone = 0  # counts in a row without any worker
        self._own: Any = None
        self._begun = threading.Event()
        self._begun.set()
        distributed = _distributed()
        # Our messages report what goes wrong; its own would stand among them.
        for name in LOGGERS:
            logging.getLogger(name).setLevel(SILENT)
        try:
            if address == LOCAL:
                self._begin(distributed, workers or cores())
            self._connect(distributed, self._own or address)
        except BaseException:
            self.close()
            raise
        self.workers = sum(self._client.nthreads().values())

    def _begin(self, distributed: Any, workers: int) -> None:
        import dask

        def begin() -> None:
            try:
                with (
                    dask.config.set({"distributed.scheduler.allowed-failures": MAX_ATTEMPTS - 1}),
                    hide_main_module(),
                    block_signals(),
                ):
                    self._own = distributed.LocalCluster(
                        n_workers=workers,
                        threads_per_worker=1,
                        processes=True,
                        host="127.0.0.1",
                        dashboard_address="127.0.0.1:0",
                        silence_logs=SILENT,
                        preload=["gaitsim.evaluation.preload"],
                    )
            except Exception as error:
                failed.append(error)
            finally:
                self._begun.set()

        failed: list[Exception] = []
        # In a thread, as Ctrl-C would leave it half started, and nothing could end it then.
        self._begun.clear()
        threading.Thread(target=begin, daemon=True).start()
        self._begun.wait()  # not `join`, which returns early after an interrupt
        if failed:
            raise failed[0]
        self.address = self._own.scheduler_address

    def _connect(self, distributed: Any, where: Any) -> None:
        def connect() -> None:
            try:
                made.append(distributed.Client(where, timeout=PATIENCE, set_as_default=False))
            except (OSError, ValueError, TypeError, ImportError) as error:
                reasons.append(str(error) or type(error).__name__)

        made: list[Any] = []
        reasons: list[str] = []
        # In a thread, as it would wait forever for another program that listens there.
        connecting = threading.Thread(target=connect, daemon=True)
        connecting.start()
        connecting.join(PATIENCE + 2)
        if not made:
            raise _unreachable(self.address, reasons[0] if reasons else "no answer as from Dask")
        client = made[0]
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            client.close()
            raise GaitsimError(
                f"the Dask scheduler at {self.address} has no workers",
                remedy=f"start some: dask worker {self.address} --nthreads 1 --nworkers auto",
            ) from None
        self._client = client  # before the callbacks, which run in the client's thread
        client.subscribe_topic("all", self._hear)
        client.loop.add_callback(self._count_soon)  # workers may have joined before

    def _hear(self, event: tuple[float, Any]) -> None:
        """Handle an event of the cluster, in the client's thread."""
        _, news = event
        action = news.get("action") if isinstance(news, dict) else None
        if action not in {"add-worker", "remove-worker"} or self._closing:
            return
        if action == "remove-worker" and not news.get("expected"):
            self._on_warning("a Dask worker was lost; another one repeats its work")
        self._count_soon()

    def _count_soon(self) -> None:
        """Schedule one count of the workers, however many events there are."""
        if not self._counting:
            self._counting = True
            self._client.loop.call_later(COUNT, self._count)

    async def _count(self) -> None:
        self._counting = False
        if self._closing:
            return
        try:
            threads = sum((await self._client.nthreads()).values())
        except Exception:  # the next request reports a scheduler that is lost
            return
        # If none are left, small work is done here, as with a single one.
        self.workers = max(1, threads)
        self._alone = 0 if threads else self._alone + 1
        if self._alone == ALONE and not self._closing:
            self._on_warning(
                "no Dask workers are left; their work waits for one. Start it with: "
                f"dask worker {self._client.scheduler.address} --nthreads 1"
            )
        if self._alone:
            self._count_soon()

    def check(self, experiments: Iterable[Experiment]) -> None:
        """Check that all workers have the packages of experiments in the local versions."""
        here = needed(experiments)
        find = finder(here)
        with self._reaching():
            there = {
                **{f"worker {name}": found for name, found in self._client.run(find).items()},
                # It reads the tasks, too.
                "scheduler": self._client.run_on_scheduler(find),
            }
        compare(here, there)

    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Hand all tasks to the scheduler."""
        distributed = _distributed()
        with self._reaching():
            futures = self._client.map(function, tasks, pure=False)
        places = {future.key: place for place, future in enumerate(futures)}
        try:
            done = distributed.as_completed(futures, self._client.loop, with_results=True)
            del futures  # so that each result is freed once it is read
            while places:
                with self._reaching():
                    future, result = next(done)
                yield places.pop(future.key), result
        finally:
            if places:
                with suppress(Exception):
                    done.clear()

    def map(self, function: Callable[[Task], Result], tasks: Sequence[Task]) -> list[Result]:
        """Return the results in the tasks' order, fetched at once when all are finished."""
        distributed = _distributed()
        with self._reaching():
            futures = self._client.map(function, tasks, pure=False)
            try:
                # `gather` would wait, too; but interrupted, it prints a traceback for each task.
                for future in distributed.as_completed(futures, self._client.loop):
                    if future.status != "finished":
                        future.result()  # raises
                return list(self._client.gather(futures))
            except Exception:
                with suppress(Exception):
                    self._client.cancel(futures)
                raise

    @contextmanager
    def _reaching(self) -> Iterator[None]:
        """Report a scheduler that is gone, and a task that ends its workers."""
        from concurrent.futures import CancelledError

        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        try:
            yield
        except KilledWorker as error:
            deaths = error.allowed_failures + 1
            raise WorkerLostError(f"{deaths} Dask workers died over the same work") from None
        except (CancelledError, CommClosedError, TimeoutError):
            raise GaitsimError(
                f"the connection to the Dask scheduler at {self.address} was lost",
                remedy="check that the scheduler runs",
            ) from None

    def close(self) -> None:
        """Leave the cluster; end workers of our own.

        Ctrl-C waits for that: a cluster that is half closed delays the program's end by ten
        seconds, and its starting workers complain.
        """

        def end() -> None:
            self._begun.wait(PATIENCE)
            with suppress(Exception):  # it may be lost already
                self._client.close(timeout=2)
            if self._own is not None:
                with suppress(Exception):
                    self._own.close(timeout=5)
            ended.set()

        self._closing = True
        ended, interrupted = threading.Event(), False
        threading.Thread(target=end, daemon=True).start()
        while not ended.is_set():
            try:
                ended.wait()
            except KeyboardInterrupt:
                interrupted = True
        if interrupted:
            raise KeyboardInterrupt


def _distributed() -> Any:
    try:
        import distributed
    except ModuleNotFoundError:
        raise not_installed("--dask", "distributed", "dask") from None
    return distributed


def _unreachable(address: str, reason: str) -> GaitsimError:
    return GaitsimError(
        f"cannot reach a Dask scheduler at {address!r}: {reason}",
        where="--dask",
        allowed="'local', or the address that 'dask scheduler' prints, such as tcp://host:8786",
        remedy="check that the scheduler runs and that this machine may reach it",
    )
