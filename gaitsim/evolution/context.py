"""Build the context of a call to a search, and check the state that it returns."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gaitsim.contracts import Array, Context, Genomes, GenomeSpace, State
from gaitsim.contracts.search import STATE_DTYPES
from gaitsim.evaluation.streams import Purpose, stream
from gaitsim.evolution.operators import ExperimentOperators, repair_genomes
from gaitsim.evolution.transferability import RealityTests
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
