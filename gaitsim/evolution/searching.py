"""Call the methods of an experiment's search, such as `ask` and `tell`, and check its contract."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gaitsim.contracts import (
    Context,
    Genomes,
    GenomeSpace,
    Members,
    Parents,
    Results,
    Search,
    State,
)
from gaitsim.contracts.search import NO_STARTS
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluation
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evaluation.streams import Purpose
from gaitsim.evolution.constraints import ConstrainedSearch
from gaitsim.evolution.context import check_state, context, start_points
from gaitsim.evolution.transferability import TransferabilitySearch
from gaitsim.experiment import Experiment
from gaitsim.registry import Entry, contract_error, plugin_errors


def search_of(experiment: Experiment) -> Search | TransferabilitySearch | ConstrainedSearch:
    """Return the search, with tests in reality or with constraints if the experiment has them."""
    if experiment.constraints.names:
        return ConstrainedSearch(experiment)
    return experiment.search if experiment.reality is None else TransferabilitySearch(experiment)


def initial_state(
    experiment: Experiment, space: GenomeSpace, starts: Genomes | None = None, island: int = 0
) -> State:
    """Return the state of a search before its first generation; see `ask` for `starts`."""
    starts = start_points(experiment, space) if starts is None else starts
    with plugin_errors(experiment.entries["search"], "creating its initial state"):
        state = search_of(experiment).initial(
            context(experiment, space, 1, Purpose.STATE, island=island, starts=starts)
        )
    return check_state(experiment, state)


def ask(
    experiment: Experiment,
    space: GenomeSpace,
    state: State,
    last: Results | None,
    generation: int,
    *,
    island: int = 0,
    populations: tuple[int, ...] = (),
    starts: Genomes | None = None,
    record_parents: Callable[[Parents], object] | None = None,
) -> tuple[Genomes, State]:
    """Ask the search for a generation's genomes.

    Args:
        experiment: experiment with the search and the seed.
        space: genome space.
        state: state of the search.
        last: previous generation; None for the first one.
        generation: number of the generation.
        island: number of the island; each island has its own random streams.
        populations: shape of several populations that share the random streams; () for one.
        starts: genomes around which the first generation is drawn, (starts, genes); None uses those
            that the option `search.start` chooses.
        record_parents: function that receives the parents of the genomes, if the search names them.

    Returns:
        Genomes, (*populations, population, genes), and the state to pass to `tell`.
    """
    entry = experiment.entries["search"]
    purpose = Purpose.INITIAL if last is None else Purpose.ASK
    if last is not None:
        starts = NO_STARTS
    elif starts is None:
        starts = start_points(experiment, space)
    details = context(
        experiment,
        space,
        generation,
        purpose,
        island=island,
        populations=populations,
        starts=starts,
    )
    if record_parents is not None:
        pool = pool_of(experiment, state, last)
        details = replace(
            details, record_parents=_checked_parents(entry, details, pool, record_parents)
        )
    with plugin_errors(entry, "choosing genomes"):
        genomes, found = search_of(experiment).ask(state, last, details)
    shape = (*populations, experiment.evolution.population, space.genes)
    if not (isinstance(genomes, np.ndarray) and genomes.shape == shape):
        raise contract_error(
            entry,
            f"returned genomes of shape {np.shape(genomes)} from ask()",
            f"(population, genes) = {shape}",
        )
    if not space.contains(genomes.reshape(-1, space.genes)):
        raise contract_error(
            entry,
            "returned genomes from ask() that are invalid for the body",
            "genomes of its genome space, as context.repair() returns them",
        )
    return genomes, check_state(experiment, found)


def pool_of(experiment: Experiment, state: State, last: Results | None) -> Genomes:
    """Return the genomes whose rows `Parents` names, (genomes, genes)."""
    with plugin_errors(experiment.entries["search"], "listing the genomes it remembers"):
        found = search_of(experiment).remembered(state)
    if found is not None:
        return found
    return experiment.space().no_genomes if last is None else last.genomes


def _checked_parents(
    entry: Entry, details: Context, pool: Genomes, record: Callable[[Parents], object]
) -> Callable[..., None]:
    """Return a function that checks parents, and passes them on."""
    shape = (details.population, 2)

    def checked(parents: Parents, before_mutation: Genomes | None = None) -> None:
        valid = isinstance(parents, np.ndarray) and parents.shape == shape
        rows = len(pool)
        if not (valid and parents.dtype == np.int64 and ((parents >= -1) & (parents < rows)).all()):
            what = "records parents of the wrong shape or dtype, or that do not exist"
            allowed = f"int64 of shape {shape}, rows below {rows}, or −1 for none"
            raise contract_error(entry, what, allowed)
        if before_mutation is not None and rows:
            # A child that equals a parent before mutation was not crossed.
            main, other = parents.T
            copied, mated = ((pool[one] == before_mutation).all(axis=1) for one in (main, other))
            copied &= main >= 0
            mated &= (other >= 0) & ~copied
            main = np.where(mated, other, main)
            parents = np.stack([main, np.where(copied | mated, -1, other)], axis=1)
        record(parents)

    return checked


def first_population(experiment: Experiment) -> Genomes:
    """Return the genomes of generation 1 of one population, (population, genes)."""
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
    """Return the state of the search, given the results of the genomes that it asked for."""
    details = context(experiment, space, generation, Purpose.TELL, island=island)
    with plugin_errors(experiment.entries["search"], "receiving scores"):
        state = search_of(experiment).tell(state, results, details)
    return check_state(experiment, state)


def results(genomes: Genomes, evaluation: Evaluation) -> Results:
    """Return an evaluated population in the form that `Search.tell` receives."""
    return Results(genomes, evaluation.scores, evaluation.values)


def reevaluate_remembered(
    experiment: Experiment,
    state: State,
    evaluate: Evaluate,
    generation: int,
    *,
    redrawn: bool = False,
) -> tuple[State, int]:
    """Re-evaluate the genomes whose scores the state holds, in the worlds of a generation.

    Called after the body, the fitness or the worlds have changed.

    Args:
        experiment: experiment with the body, the fitness and the worlds.
        state: state of the search.
        evaluate: function that scores genomes in the worlds of a generation.
        generation: number of the generation.
        redrawn: whether only the worlds have changed.

    Returns:
        The state, and the number of genomes that were evaluated.
    """
    search, entry = search_of(experiment), experiment.entries["search"]
    space = experiment.space()
    with plugin_errors(entry, "listing the genomes it remembers"):
        genomes = search.remembered(state)
    if genomes is None or not len(genomes):
        genomes = space.no_genomes
        again = Results(genomes, np.empty(0), dict.fromkeys(experiment.search.reads(), np.empty(0)))
    else:
        again = results(genomes, evaluate(genomes, generation))
    details = context(experiment, space, generation, Purpose.TELL, redrawn=redrawn)
    with plugin_errors(entry, "receiving new scores"):
        state = search.rescored(state, again, details)
    return check_state(experiment, state), len(genomes)


def finished(experiment: Experiment, state: State) -> str:
    """Return why the search ends the run; '' if it continues."""
    with plugin_errors(experiment.entries["search"], "saying whether it has finished"):
        return str(search_of(experiment).finished(state))


def figures(experiment: Experiment, state: State) -> dict[str, float]:
    """Return the figures that the search reports for the history, by name."""
    with plugin_errors(experiment.entries["search"], "describing its state"):
        found = search_of(experiment).figures(state)
        return {str(name): float(value) for name, value in found.items()}


def members(experiment: Experiment, state: State) -> Members | None:
    """Return the front or archive of a search; None for a search without one."""
    with plugin_errors(experiment.entries["search"], "listing its members"):
        return search_of(experiment).members(state)


def centre(experiment: Experiment, state: State) -> Genomes | None:
    """Return the genome amid those that the search draws, (genes,); None for other searches."""
    entry, space = experiment.entries["search"], experiment.space()
    with plugin_errors(entry, "returning its centre"):
        found = search_of(experiment).centre(state, space)
    if found is not None and not (np.ndim(found) == 1 and space.contains(found[None])):
        raise contract_error(entry, "returned a centre that is not a genome of the body")
    return found


def state_mismatch(experiment: Experiment, state: State, generation: int) -> str:
    """Return why a stored state does not fit the search of an experiment; '' if it does."""
    details = context(experiment, experiment.space(), generation + 1, Purpose.STATE)
    try:
        return search_of(experiment).mismatch(state, details)
    except KeyError as error:
        return f"it lacks the array {error.args[0]!r}"
    except GaitsimError:
        raise
    except Exception as error:
        return f"it cannot be read: {error}"
