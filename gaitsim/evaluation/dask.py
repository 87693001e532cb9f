"""Run tasks on a Dask cluster: an existing one, or a local one that gaitsim starts."""

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
from gaitsim.evaluation.processes import OnWarning, block_signals, hide_main_module
from gaitsim.evaluation.serialized import check_versions, required_versions, version_finder
from gaitsim.experiment import Experiment

LOCAL = "local"
ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://.")
LOGGERS = ("distributed", "distributed.client")  # Dask sets the level of the second one itself
SILENT = logging.CRITICAL + 1
TIMEOUT = 10  # timeout for the scheduler to answer, and for its first worker to join, s
COUNT_DELAY = 1.0  # delay from a change among the workers to the next count, s
MAX_EMPTY_COUNTS = (
    5  # counts without a worker until a warning; a worker that died restarts within two
)


class DaskExecutor(Executor):
    """Runs tasks on the workers of a Dask scheduler.

    The Dask cluster must be trusted: its scheduler and workers can run any code on this machine,
    and this program can run any code on theirs.

    Args:
        address: address of the scheduler, such as 'tcp://host:8786'; or 'local' to start workers
            on this machine, which always end together with this process.
        workers: number of local workers; None for one per core.
        on_warning: called with a message when a worker is lost, and when no worker is left.

    Attributes:
        address: address of the scheduler.
        workers: current number of threads of all workers. Workers may join and leave.
    """

    def __init__(
        self, address: str, workers: int | None = None, on_warning: OnWarning = lambda text: None
    ) -> None:
        if workers is not None and address != LOCAL:
            raise GaitsimError(
                f"--workers {workers} cannot be combined with --dask {address}",
                remedy="omit --workers, which is only for --dask local",
            )
        if address != LOCAL and not ADDRESS.match(address):
            raise _unreachable(address, "not an address")
        self.address = address
        self._on_warning = on_warning
        self._closing = False
        self._counting = False
        self._empty_counts = 0  # counts in a row without any worker
        self._cluster: Any = None
        self._started = threading.Event()
        self._started.set()
        distributed = _distributed()
        # gaitsim reports errors itself; Dask's log messages would mix with its own.
        for name in LOGGERS:
            logging.getLogger(name).setLevel(SILENT)
        try:
            if address == LOCAL:
                self._start_cluster(distributed, workers or cores())
            self._connect(distributed, self._cluster or address)
        except BaseException:
            self.close()
            raise
        self.workers = sum(self._client.nthreads().values())

    def _start_cluster(self, distributed: Any, workers: int) -> None:
        import dask

        def start() -> None:
            try:
                with (
                    dask.config.set({"distributed.scheduler.allowed-failures": MAX_ATTEMPTS - 1}),
                    hide_main_module(),
                    block_signals(),
                ):
                    self._cluster = distributed.LocalCluster(
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
                self._started.set()

        failed: list[Exception] = []
        # In a thread, because Ctrl-C would leave a half-started cluster that nothing could stop.
        self._started.clear()
        threading.Thread(target=start, daemon=True).start()
        self._started.wait()  # not `join`, which returns early after an interrupt
        if failed:
            raise failed[0]
        self.address = self._cluster.scheduler_address

    def _connect(self, distributed: Any, where: Any) -> None:
        def connect() -> None:
            try:
                clients.append(distributed.Client(where, timeout=TIMEOUT, set_as_default=False))
            except (OSError, ValueError, TypeError, ImportError) as error:
                reasons.append(str(error) or type(error).__name__)

        clients: list[Any] = []
        reasons: list[str] = []
        # In a thread, because the client waits forever if another program listens at the address.
        connecting = threading.Thread(target=connect, daemon=True)
        connecting.start()
        connecting.join(TIMEOUT + 2)
        if not clients:
            raise _unreachable(self.address, reasons[0] if reasons else "no answer from Dask")
        client = clients[0]
        try:
            client.wait_for_workers(1, timeout=TIMEOUT)
        except TimeoutError:
            client.close()
            raise GaitsimError(
                f"the Dask scheduler at {self.address} has no workers",
                remedy=f"start some: dask worker {self.address} --nthreads 1 --nworkers auto",
            ) from None
        self._client = client  # before the callbacks, which run in the client's thread
        client.subscribe_topic("all", self._on_event)
        client.loop.add_callback(self._count_soon)  # workers may already have joined

    def _on_event(self, event: tuple[float, Any]) -> None:
        """Handle an event of the cluster, in the client's thread."""
        _, message = event
        action = message.get("action") if isinstance(message, dict) else None
        if action not in {"add-worker", "remove-worker"} or self._closing:
            return
        if action == "remove-worker" and not message.get("expected"):
            self._on_warning("a Dask worker was lost; another one repeats its tasks")
        self._count_soon()

    def _count_soon(self) -> None:
        """Schedule a count of the workers; events until then share one count."""
        if not self._counting:
            self._counting = True
            self._client.loop.call_later(COUNT_DELAY, self._count)

    async def _count(self) -> None:
        self._counting = False
        if self._closing:
            return
        try:
            threads = sum((await self._client.nthreads()).values())
        except Exception:  # the next request reports a lost scheduler
            return
        # Without workers, act as with one worker: this process evaluates small populations.
        self.workers = max(1, threads)
        self._empty_counts = 0 if threads else self._empty_counts + 1
        if self._empty_counts == MAX_EMPTY_COUNTS and not self._closing:
            self._on_warning(
                "no Dask workers are left; the tasks wait for a new one. Start one with: "
                f"dask worker {self._client.scheduler.address} --nthreads 1"
            )
        if self._empty_counts:
            self._count_soon()

    def check(self, experiments: Iterable[Experiment]) -> None:
        """Check that all workers have the local versions of the packages that experiments use."""
        here = required_versions(experiments)
        find = version_finder(here)
        with self._convert_errors():
            there = {
                **{f"worker {name}": found for name, found in self._client.run(find).items()},
                # The scheduler unpickles tasks, too.
                "scheduler": self._client.run_on_scheduler(find),
            }
        check_versions(here, there)

    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Submit all tasks to the scheduler; yield the index and result of each as it finishes."""
        distributed = _distributed()
        with self._convert_errors():
            futures = self._client.map(function, tasks, pure=False)
        places = {future.key: place for place, future in enumerate(futures)}
        try:
            done = distributed.as_completed(futures, self._client.loop, with_results=True)
            del futures  # free each result as soon as it has been read
            while places:
                with self._convert_errors():
                    future, result = next(done)
                yield places.pop(future.key), result
        finally:
            if places:
                with suppress(Exception):
                    done.clear()

    def map(
        self,
        function: Callable[[Task], Result],
        tasks: Sequence[Task],
        on_result: Callable[[int], object] = lambda place: None,
    ) -> list[Result]:
        """Return the results in the order of the tasks, fetched together when all are finished."""
        distributed = _distributed()
        with self._convert_errors():
            futures = self._client.map(function, tasks, pure=False)
            places = {future.key: place for place, future in enumerate(futures)}
            try:
                # `gather` alone would print a traceback for each task when interrupted.
                for future in distributed.as_completed(futures, self._client.loop):
                    if future.status != "finished":
                        future.result()  # raises
                    on_result(places[future.key])
                return list(self._client.gather(futures))
            except Exception:
                with suppress(Exception):
                    self._client.cancel(futures)
                raise

    @contextmanager
    def _convert_errors(self) -> Iterator[None]:
        """Convert Dask's errors about a lost scheduler, or a task that kills its workers."""
        from concurrent.futures import CancelledError

        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        try:
            yield
        except KilledWorker as error:
            deaths = error.allowed_failures + 1
            raise WorkerLostError(f"{deaths} Dask workers died on the same task") from None
        except (CancelledError, CommClosedError, TimeoutError):
            raise GaitsimError(
                f"the connection to the Dask scheduler at {self.address} was lost",
                remedy="check that the scheduler is running",
            ) from None

    def close(self) -> None:
        """Leave the cluster, and stop local workers.

        Ctrl-C takes effect afterwards: a half-closed cluster delays the end of the program by ten
        seconds, and workers that are still starting print errors.
        """

        def end() -> None:
            self._started.wait(TIMEOUT)
            with suppress(Exception):  # the connection may already be lost
                self._client.close(timeout=2)
            if self._cluster is not None:
                with suppress(Exception):
                    self._cluster.close(timeout=5)
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
        remedy="check that the scheduler is running, and that this machine can connect to it",
    )
