"""Processor time of evaluation, in a module that worker processes can import, too."""

import time

from gaitsim.contracts import Genomes
from gaitsim.evaluation import evaluate
from gaitsim.experiment import Experiment


def processor_seconds(experiment: Experiment, genomes: Genomes) -> float:
    """CPU seconds of one evaluation, whatever else the machine does."""
    start = time.process_time()
    evaluate(experiment, genomes)
    return time.process_time() - start
