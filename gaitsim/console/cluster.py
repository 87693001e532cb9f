"""The Dask cluster chosen by `--dask`, for the duration of a command."""

from collections.abc import Iterator
from contextlib import contextmanager

from gaitsim.console.printing import notice, status
from gaitsim.evaluation import Executor
from gaitsim.evaluation.dask import LOCAL, DaskExecutor


def warn(text: str) -> None:
    """Print a warning."""
    notice(f"Warning: {text}")


@contextmanager
def cluster(address: str | None, workers: int | None) -> Iterator[Executor | None]:
    """Connect to the cluster at an address, or start one for 'local'; yield None for None."""
    if address is None:
        yield None
        return
    message = "Starting Dask workers …" if address == LOCAL else f"Connecting to {address} …"
    with status(message):
        executor = DaskExecutor(address, workers, warn)
    with executor:
        yield executor
