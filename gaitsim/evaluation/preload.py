"""Loaded by Dask workers of our own when they start."""

import os
import signal


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C to the program that started this worker: it saves, then ends the worker."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    os.dup2(2, 1)  # plugins may print; standard output is for results
