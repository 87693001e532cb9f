"""Processor time of judging, in a module that worker processes can import, too."""

import time

from gaitsim.contracts import Genomes
from gaitsim.evaluation import judge
from gaitsim.experiment import Experiment


def processor_seconds(experiment: Experiment, genomes: Genomes) -> float:
    """What judging takes of a core, whatever else the machine does."""
    start = time.process_time()
    judge(experiment, genomes)
    return time.process_time() - start
