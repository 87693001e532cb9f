"""The Dask cluster that `--dask` names, for as long as a command needs it."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

from gaitsim.cli.console import errors, notice
from gaitsim.evaluation import Executor
from gaitsim.evaluation.dask import LOCAL, DaskExecutor


def warn(text: str) -> None:
    """Say what a user should know of the workers."""
    notice(f"Warning: {text}")


@contextmanager
def cluster(address: str | None, workers: int | None) -> Iterator[Executor | None]:
    """The cluster at an address, 'local' for one of our own; None where none is asked for.

    Raises:
        GaitsimError: it cannot be reached.
    """
    if address is None:
        yield None
        return

    console = errors()
    doing = "Starting Dask workers …" if address == LOCAL else f"Connecting to {address} …"
    with console.status(doing) if console.is_terminal else nullcontext():
        executor = DaskExecutor(address, workers, warn)
    with executor:
        yield executor
