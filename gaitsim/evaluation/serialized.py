"""Experiments in a form that can be sent to workers."""

import gc
import socket
from functools import lru_cache

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.packages import check_versions, required_versions, version_finder
from gaitsim.evaluation.scoring import evaluate
from gaitsim.experiment import Experiment, parse_experiment
from gaitsim.registry import plugin_errors


class SerializedExperiment:
    """An experiment that is pickled as TOML; each worker process parses it once."""

    def __init__(self, experiment: Experiment) -> None:
        self._experiment: Experiment | None = experiment
        self._state: State | None = None

    def __getstate__(self) -> "State":
        if self._state is None:
            experiment = self.experiment
            for entry in experiment.in_python:
                raise GaitsimError(
                    f"the {entry} cannot be sent to other processes",
                    where=entry.target,
                    remedy="run it without workers, or create a package: 'gaitsim plugins new'",
                )
            self._state = experiment.to_toml(), tuple(required_versions([experiment]).items())
        return self._state

    def __setstate__(self, state: "State") -> None:
        self._experiment, self._state = None, state

    @property
    def experiment(self) -> Experiment:
        """The experiment, ready to evaluate; in its original process, the same object."""
        return self._experiment or _parse(*self.__getstate__())


State = tuple[str, tuple[tuple[str, str], ...]]
"""An experiment's TOML, and its packages with their versions."""


@lru_cache(maxsize=4)
def _parse(toml: str, packages: tuple[tuple[str, str], ...]) -> Experiment:
    # This worker may have joined after the packages of all workers were checked.
    required = dict(packages)
    check_versions(required, {f"worker on {socket.gethostname()}": version_finder(required)()})
    experiment = parse_experiment(toml, "the experiment")
    prepare(experiment)
    return experiment


def prepare(experiment: Experiment, individuals: int = 1) -> None:
    """Evaluate random genomes, so that this process compiles or loads its kernels."""
    with plugin_errors(experiment.entries["organism"], "drawing genomes"):
        space = experiment.organism.genome_space()
        genomes = space.random(individuals, np.random.default_rng(0))
    # Compiling creates many objects that live on; 10% of the time would go to the collector.
    collecting = gc.isenabled()
    gc.disable()
    try:
        evaluate(experiment, genomes)
    finally:
        if collecting:
            gc.enable()
