"""Call the methods of an experiment's search, such as `ask` and `tell`, and check its contract."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gaitsim.contracts import Array, Context, Genomes, GenomeSpace, Members, Results, State
from gaitsim.contracts.search import STATE_DTYPES
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluation
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evaluation.streams import Purpose, stream
from gaitsim.evolution.operators import ExperimentOperators, repair_genomes
from gaitsim.evolution.transferability import (
    RealityTests,
    pool_results,
    repeat_reality_tests,
    run_reality_test,
    search_state,
    with_kept_values,
    with_predictions,
)
from gaitsim.experiment import Experiment
from gaitsim.registry import contract_error, plugin_errors


@dataclass(frozen=True, eq=False, kw_only=True)
class _CheckedContext(Context):
    """A context that reports invalid genomes as errors of the body."""

    experiment: Experiment

    def random(self, count: int) -> Genomes:
        body = self.experiment.entries["organism"]
        with plugin_errors(body, "drawing genomes"):
            genomes = self.space.random(count, self.rng)
            valid = self.space.contains(genomes) and len(genomes) == count
        if not valid:
            raise contract_error(body, "draws genomes outside its own genome space")
        return genomes

    def repair(self, genomes: Genomes) -> Genomes:
        return repair_genomes(self.experiment, self.space, genomes)


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
    """Return the context of a call to the search of an experiment."""
    operators = None
    if experiment.search.operators:
        operators = ExperimentOperators(experiment, space, generation, island)
    return _CheckedContext(
        space=space,
        population=experiment.evolution.population,
        generation=generation,
        rng=stream(experiment.seed, generation, purpose, island),
        start=start,
        populations=populations,
        operators=operators,
        experiment=experiment,
    )


def check_state(experiment: Experiment, state: State, tests: RealityTests | None = None) -> State:
    """Check a state; return it as plain arrays for a checkpoint, with the tests in reality."""
    entry = experiment.entries["search"]
    if not isinstance(state, Mapping):
        raise contract_error(entry, f"returned a {type(state).__name__} as its state", "a mapping")
    for name, values in state.items():
        if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200):
            what = f"names an array of its state {name!r:.80}"
            raise contract_error(entry, what, "a printable string of 1 to 200 characters")
        if not isinstance(values, np.ndarray) or values.dtype.str not in STATE_DTYPES:
            kind = values.dtype if isinstance(values, np.ndarray) else type(values).__name__
            raise contract_error(
                entry,
                f"stores {name!r} in its state as {kind}",
                "arrays of float64, int64, uint8 or bool",
            )
    found = {**state, **tests.arrays()} if tests is not None else state
    # In C order, as a checkpoint restores arrays: the last bit of a sum depends on memory order.
    found = {name: np.asarray(values, order="C") for name, values in found.items()}
    for values in found.values():
        values.setflags(write=False)
    return found


def initial_state(
    experiment: Experiment, space: GenomeSpace, start: Array | None = None, island: int = 0
) -> State:
    """Return the state of a search before its first generation."""
    entry = experiment.entries["search"]
    with plugin_errors(entry, "creating its initial state"):
        state = experiment.search.initial(
            context(experiment, space, 1, Purpose.STATE, island=island, start=start)
        )
    tests = None if experiment.reality is None else RealityTests.none(space)
    return check_state(experiment, state, tests)


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
        experiment: experiment with the search and the seed.
        space: genome space.
        state: state of the search.
        last: previous generation; None for the first one.
        generation: number of the generation.
        island: number of the island; each island has its own random streams.
        populations: shape of several populations that share the random streams; () for one.
        start: genome around which the first generation is drawn, (genes,).

    Returns:
        Genomes, (*populations, population, genes), and the state to pass to `tell`.
    """
    entry = experiment.entries["search"]
    purpose = Purpose.INITIAL if last is None else Purpose.ASK
    details = context(
        experiment,
        space,
        generation,
        purpose,
        island=island,
        populations=populations,
        start=start,
    )
    tests = RealityTests.of(state)
    if tests is not None and last is not None:
        last = with_predictions(experiment, tests, last)
    with plugin_errors(entry, "choosing genomes"):
        genomes, found = experiment.search.ask(search_state(state), last, details)
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
    return genomes, check_state(experiment, found, tests)


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
    tests, before = RealityTests.of(state), search_state(state)
    seen = results if tests is None else with_predictions(experiment, tests, results)
    details = context(experiment, space, generation, Purpose.TELL, island=island)
    with plugin_errors(experiment.entries["search"], "receiving scores"):
        after = experiment.search.tell(before, seen, details)
    after = check_state(experiment, after)
    if tests is None:
        return after
    pool = pool_results(tests, remembered(experiment, before), results)
    tests, kept = with_kept_values(tests, pool, remembered(experiment, after))
    if (generation - 1) % experiment.transferability.every == 0:
        more = run_reality_test(experiment, tests, kept, generation)
        if more is not None:
            again = with_predictions(experiment, more, kept)
            after = _replace_scores(experiment, space, after, again, generation, island)
            tests, _ = with_kept_values(more, kept, remembered(experiment, after))
    return check_state(experiment, after, tests)


def _replace_scores(
    experiment: Experiment,
    space: GenomeSpace,
    state: State,
    results: Results,
    generation: int,
    island: int = 0,
) -> State:
    details = context(experiment, space, generation, Purpose.TELL, island=island)
    with plugin_errors(experiment.entries["search"], "receiving new scores"):
        state = experiment.search.rescored(state, results, details)
    return check_state(experiment, state)


def remembered(experiment: Experiment, state: State) -> Genomes:
    """Return the genomes whose scores the state holds, (genomes, genes); possibly none."""
    with plugin_errors(experiment.entries["search"], "listing the genomes it remembers"):
        genomes = experiment.search.remembered(search_state(state))
    return experiment.space().random(0, np.random.default_rng(0)) if genomes is None else genomes


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
        redrawn: whether only the worlds have changed; the costly tests in reality are then not
            repeated.

    Returns:
        The state, and the number of genomes that were evaluated.
    """
    space, tests = experiment.space(), RealityTests.of(state)
    genomes = remembered(experiment, state)
    if not len(genomes):
        return state, 0
    again = results(genomes, evaluate(genomes, generation))
    if tests is None:
        return _replace_scores(experiment, space, state, again, generation), len(genomes)
    if tests.count:
        simulated = evaluate(tests.genomes, generation)
        tests = repeat_reality_tests(experiment, tests, simulated, again, in_reality=not redrawn)
    after = _replace_scores(
        experiment,
        space,
        search_state(state),
        with_predictions(experiment, tests, again),
        generation,
    )
    tests, _ = with_kept_values(tests, again, remembered(experiment, after))
    return check_state(experiment, after, tests), len(genomes) + tests.count


def figures(experiment: Experiment, state: State) -> dict[str, float]:
    """Return the figures that the search reports for the history, by name."""
    entry = experiment.entries["search"]
    with plugin_errors(entry, "describing its state"):
        found = experiment.search.figures(search_state(state))
        return {str(name): float(value) for name, value in found.items()}


def members(experiment: Experiment, state: State) -> Members | None:
    """Return the front or archive of a search; None for a search without one."""
    with plugin_errors(experiment.entries["search"], "listing its members"):
        return experiment.search.members(search_state(state))


def state_mismatch(experiment: Experiment, state: Mapping[str, Array], generation: int) -> str:
    """Return why a stored state does not fit the search of an experiment; '' if it does."""
    details = context(experiment, experiment.space(), generation + 1, Purpose.STATE)
    try:
        wrong = experiment.search.mismatch(search_state(state), details)
        tests = None if experiment.reality is None else RealityTests.of(state)
        if wrong or experiment.reality is None:
            return wrong
        return tests.mismatch(details.space.genes) if tests else "it lacks the tests in reality"
    except KeyError as error:
        return f"it lacks the array {error.args[0]!r}"
    except GaitsimError:
        raise
    except Exception as error:
        return f"it cannot be read: {error}"
