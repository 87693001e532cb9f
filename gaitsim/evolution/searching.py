"""Ask an experiment's search for genomes and tell it their scores, and hold it to its contract."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from gaitsim.contracts import Array, Context, Genomes, GenomeSpace, Members, Results, State
from gaitsim.contracts.search import STATE_DTYPES
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluation
from gaitsim.evaluation.streams import Purpose, stream
from gaitsim.evolution.operators import ExperimentOperators, repaired
from gaitsim.experiment import Experiment
from gaitsim.registry import contract_error, plugin_errors


@dataclass(frozen=True, eq=False, kw_only=True)
class _Checked(Context):
    """A context that blames the body for genomes that are not of its space."""

    experiment: Experiment

    def random(self, count: int) -> Genomes:
        body = self.experiment.entries["organism"]
        with plugin_errors(body, "drawing genomes"):
            genomes = self.space.random(count, self.rng)
            belongs = self.space.contains(genomes) and len(genomes) == count
        if not belongs:
            raise contract_error(body, "draws genomes that are not of its own space")
        return genomes

    def repair(self, genomes: Genomes) -> Genomes:
        return repaired(self.experiment, self.space, genomes)


def context(
    experiment: Experiment,
    space: GenomeSpace,
    generation: int,
    purpose: Purpose,
    *,
    island: int = 0,
    populations: tuple[int, ...] = (),
    start: Array | None = None,
) -> Context:
    """Return what the search of an experiment works with in one call."""
    operators = None
    if experiment.search.operators:
        operators = ExperimentOperators(experiment, space, generation, island)
    return _Checked(
        space=space,
        population=experiment.evolution.population,
        generation=generation,
        rng=stream(experiment.seed, generation, purpose, island),
        start=start,
        populations=populations,
        operators=operators,
        experiment=experiment,
    )


def initial_state(
    experiment: Experiment, space: GenomeSpace, start: Array | None = None, island: int = 0
) -> State:
    """Return the state of a search before its first generation.

    Raises:
        PluginError: the search fails or breaks its contract; names its package.
    """
    entry = experiment.entries["search"]
    with plugin_errors(entry, "beginning"):
        state = experiment.search.initial(
            context(experiment, space, 1, Purpose.STATE, island=island, start=start)
        )
    return _checked_state(experiment, state)


def ask(
    experiment: Experiment,
    space: GenomeSpace,
    state: State,
    last: Results | None,
    generation: int,
    *,
    island: int = 0,
    populations: tuple[int, ...] = (),
    start: Array | None = None,
) -> tuple[Genomes, State]:
    """Ask the search for a generation's genomes.

    Args:
        experiment: its search and seed.
        space: the genome space.
        state: of the search.
        last: the generation before; None for the first one.
        generation: number of the generation.
        island: number of the island, which has random streams of its own.
        populations: several populations that share the random streams; () for one.
        start: genome that the first generation begins from, (genes,).

    Returns:
        Genomes, (*populations, population, genes), and the state until they are told.

    Raises:
        PluginError: a plugin fails or breaks its contract; names its package.
    """
    entry = experiment.entries["search"]
    purpose = Purpose.INITIAL if last is None else Purpose.ASK
    asked = context(
        experiment,
        space,
        generation,
        purpose,
        island=island,
        populations=populations,
        start=start,
    )
    with plugin_errors(entry, "being asked for genomes"):
        genomes, state = experiment.search.ask(state, last, asked)
    shape = (*populations, experiment.evolution.population, space.genes)
    if not (isinstance(genomes, np.ndarray) and genomes.shape == shape):
        raise contract_error(
            entry,
            f"asks for genomes of shape {np.shape(genomes)}",
            f"(population, genes) = {shape}",
        )
    if not space.contains(genomes.reshape(-1, space.genes)):
        raise contract_error(
            entry, "asks for genomes outside the space of the body", "genomes within its bounds"
        )
    return genomes, _checked_state(experiment, state)


def first_population(experiment: Experiment) -> Genomes:
    """Return the genomes of generation 1 of one population, (population, genes).

    Raises:
        PluginError: a plugin fails or breaks its contract; names its package.
    """
    space = experiment.space()
    return ask(experiment, space, initial_state(experiment, space), None, 1)[0]


def tell(
    experiment: Experiment,
    space: GenomeSpace,
    state: State,
    results: Results,
    generation: int,
    island: int = 0,
) -> State:
    """Return the state of the search after the scores of the genomes that it asked for.

    Raises:
        PluginError: the search fails or breaks its contract; names its package.
    """
    with plugin_errors(experiment.entries["search"], "being told scores"):
        state = experiment.search.tell(
            state, results, context(experiment, space, generation, Purpose.TELL, island=island)
        )
    return _checked_state(experiment, state)


def results(genomes: Genomes, evaluation: Evaluation) -> Results:
    """Return an evaluated population as a search is told it."""
    return Results(genomes, evaluation.scores, evaluation.values)


def rescored(
    experiment: Experiment,
    state: State,
    evaluate: Callable[[Genomes], Evaluation],
    generation: int,
) -> tuple[State, int]:
    """Re-evaluate the genomes whose scores the state holds, for a changed body or fitness.

    Returns:
        The state, and the number of genomes that were evaluated.

    Raises:
        PluginError: a plugin fails or breaks its contract; names its package.
    """
    entry, space = experiment.entries["search"], experiment.space()
    with plugin_errors(entry, "recalling genomes"):
        genomes = experiment.search.remembered(state)
    if genomes is None or not len(genomes):
        return state, 0
    again = results(genomes, evaluate(genomes))
    with plugin_errors(entry, "being told new scores"):
        told = context(experiment, space, generation, Purpose.TELL)
        state = experiment.search.rescored(state, again, told)
    return _checked_state(experiment, state), len(genomes)


def figures(experiment: Experiment, state: State) -> dict[str, float]:
    """Return what the search says of itself for the history.

    Raises:
        PluginError: the search fails or breaks its contract; names its package.
    """
    entry = experiment.entries["search"]
    with plugin_errors(entry, "describing its state"):
        found = experiment.search.figures(state)
        return {str(name): float(value) for name, value in found.items()}


def members(experiment: Experiment, state: State) -> Members | None:
    """Return the front or archive of a search; None for a search that keeps none.

    Raises:
        PluginError: the search fails; names its package.
    """
    with plugin_errors(experiment.entries["search"], "listing its members"):
        return experiment.search.members(state)


def state_mismatch(experiment: Experiment, state: Mapping[str, Array], generation: int) -> str:
    """Return why a stored state does not fit the search of an experiment, or ''.

    Raises:
        PluginError: the search fails; names its package.
    """
    asked = context(experiment, experiment.space(), generation + 1, Purpose.STATE)
    try:
        return experiment.search.mismatch(state, asked)
    except KeyError as error:
        return f"it lacks the array {error.args[0]!r}"
    except GaitsimError:
        raise
    except Exception as error:
        return f"it cannot be read: {error}"


def _checked_state(experiment: Experiment, state: State) -> State:
    """Return a state as plain arrays that a checkpoint can hold."""
    entry = experiment.entries["search"]
    if not isinstance(state, Mapping):
        raise contract_error(entry, f"returned a {type(state).__name__} as its state", "a mapping")
    for name, values in state.items():
        if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200):
            raise contract_error(entry, f"names an array of its state {name!r:.80}", "a short text")
        if not isinstance(values, np.ndarray) or values.dtype.str not in STATE_DTYPES:
            kind = values.dtype if isinstance(values, np.ndarray) else type(values).__name__
            raise contract_error(
                entry,
                f"keeps {name!r} in its state as {kind}",
                "arrays of float64, int64, uint8 or bool",
            )
        values.setflags(write=False)
    return state
