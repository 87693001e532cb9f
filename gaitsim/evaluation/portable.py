"""An experiment on its way to workers, and what a worker process is."""

import multiprocessing
import os
import signal
import threading
from functools import lru_cache

import numpy as np

from gaitsim.evaluation.judge import judge
from gaitsim.experiment import Experiment, parse_experiment
from gaitsim.registry import containing


class Portable:
    """An experiment whose TOML is what travels; each worker process makes it of that once.

    Args:
        experiment: it.
    """

    def __init__(self, experiment: Experiment) -> None:
        self._experiment: Experiment | None = experiment
        self._toml = experiment.to_toml()

    def __getstate__(self) -> str:
        return self._toml

    def __setstate__(self, toml: str) -> None:
        self._experiment, self._toml = None, toml

    @property
    def experiment(self) -> Experiment:
        """The experiment, ready to be judged by; where it came from, the very same.

        Raises:
            GaitsimError: this process lacks a plugin of it, or its body fails.
        """
        return self._experiment or _made(self._toml)


@lru_cache(maxsize=4)
def _made(toml: str) -> Experiment:
    experiment = parse_experiment(toml, "the experiment")
    prepare(experiment)
    return experiment


def prepare(experiment: Experiment) -> None:
    """Compile in this process what judging takes, or load it from the cache: judge one genome."""
    with containing(experiment.entries["organism"], "drawing genomes"):
        genome = experiment.organism.genome_space().random(1, np.random.default_rng(0))
    judge(experiment, genome)


def begin_worker() -> None:
    """Begin a worker process: stopping is its parent's affair, ending with it its own."""
    for number in (signal.SIGINT, signal.SIGTERM):  # the parent's to handle: it saves first
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this worker when its parent is gone, which may have been killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
