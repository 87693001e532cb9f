"""Set up the local Dask workers that gaitsim starts; they load this module first."""

import os
import signal


def dask_setup(worker: object) -> None:
    """Ignore Ctrl-C: the program that started this worker saves its run, then stops the worker."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    os.dup2(2, 1)  # output of plugins must not mix with results on standard output
