"""An experiment on its way to workers, and what a worker process is."""

import multiprocessing
import os
import signal
import socket
import threading
from functools import lru_cache

import numpy as np

from gaitsim.evaluation.packages import compare, installed_among, needed
from gaitsim.evaluation.scoring import evaluate
from gaitsim.experiment import Experiment, parse_experiment
from gaitsim.registry import plugin_errors


class SerializedExperiment:
    """An experiment whose TOML is what travels; each worker process makes it of that once.

    Args:
        experiment: it.
    """

    def __init__(self, experiment: Experiment) -> None:
        self._experiment: Experiment | None = experiment
        self._state: State | None = None

    def __getstate__(self) -> "State":
        if self._state is None:
            experiment = self.experiment
            self._state = experiment.to_toml(), tuple(needed([experiment]).items())
        return self._state

    def __setstate__(self, state: "State") -> None:
        self._experiment, self._state = None, state

    @property
    def experiment(self) -> Experiment:
        """The experiment, ready to be judged by; where it came from, the very same.

        Raises:
            GaitsimError: this process lacks a package of it, or has another version; or its
                body fails.
        """
        return self._experiment or _made(*self.__getstate__())


State = tuple[str, tuple[tuple[str, str], ...]]
"""An experiment's TOML, and the packages that it needs with their versions."""


@lru_cache(maxsize=4)
def _made(toml: str, packages: tuple[tuple[str, str], ...]) -> Experiment:
    # Workers may have joined after all were asked for their packages.
    here = installed_among(name for name, _ in packages)
    compare(dict(packages), {f"worker on {socket.gethostname()}": here})
    experiment = parse_experiment(toml, "the experiment")
    prepare(experiment)
    return experiment


def prepare(experiment: Experiment) -> None:
    """Evaluate one genome so that this process compiles or loads its kernels."""
    with plugin_errors(experiment.entries["organism"], "drawing genomes"):
        genome = experiment.organism.genome_space().random(1, np.random.default_rng(0))
    evaluate(experiment, genome)


def begin_worker() -> None:
    """Begin a worker process: stopping is its parent's affair, ending with it its own."""
    for number in (signal.SIGINT, signal.SIGTERM):  # the parent's to handle: it saves first
        signal.signal(number, signal.SIG_IGN)
    os.dup2(2, 1)  # what is printed here, by a plugin, is no result
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this worker when its parent is gone, which may have been killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
