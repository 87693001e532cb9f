"""Processor time of an evaluation, in a module that worker processes can import."""

import time

from gaitsim.contracts import Genomes
from gaitsim.evaluation import evaluate
from gaitsim.experiment import Experiment


def processor_seconds(experiment: Experiment, genomes: Genomes) -> float:
    """Return the CPU seconds of one evaluation, which exclude other programs."""
    start = time.process_time()
    evaluate(experiment, genomes)
    return time.process_time() - start
