"""Single steps of the genetic algorithm, run through the search of an experiment."""

from gaitsim.contracts import Results
from gaitsim.evolution import ask


def initial_population(experiment, space, island=0, populations=None):
    """Return generation 1, (population, genes), with a leading axis for several populations."""
    several = () if populations is None else (populations,)
    return ask(experiment, space, {}, None, 1, island=island, populations=several)[0]


def warm_start_population(experiment, space, start):
    return ask(experiment, space, {}, None, 1, starts=start[None])[0]


def breed(experiment, space, genomes, scores, generation, island=0):
    last, several = Results(genomes, scores), genomes.shape[:-2]
    return ask(experiment, space, {}, last, generation, island=island, populations=several)[0]
