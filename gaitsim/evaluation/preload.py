"""What a Dask worker of our own loads as it begins."""

import os
import signal


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C to the program that began this worker: it saves first, then ends it."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    os.dup2(2, 1)  # plugins may print; standard output is for results
