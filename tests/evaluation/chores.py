"""Tasks for workers in tests, in a module that worker processes can import."""

import os
import signal
import time
from pathlib import Path

from gaitsim.registry import Entry, plugin_errors


def square(number):
    return number * number


def whose(_task):
    time.sleep(0.05)  # so that every worker gets one
    return os.getpid()


def fail_at(limit, number):
    if number >= limit:
        raise ValueError(f"{number} is too much")
    return number


def die(task):
    """Kill this process as long as marks are left; then return the number."""
    number, folder = task
    marks = sorted(Path(folder).glob(f"{number}-*"))
    if marks:
        marks[0].unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def leave(status):
    with plugin_errors(Entry("organism", "hopper", "fake:Hopper", "fake", "1.0"), "moving"):
        os._exit(status)


def sleep_for(seconds):
    time.sleep(seconds)
    return seconds


def exit_like_a_user(_task):
    raise EOFError("no more input")


def return_a_function(_task):
    return lambda: None


def seeded(experiment, seed):
    return experiment.name, experiment.seed, seed
