"""Evaluate genomes for any optimiser: `gaitsim.evaluate`."""

import threading
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gaitsim.arguments import ARGUMENTS
from gaitsim.contracts import Genomes, GenomeSpace
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluation, Evaluator
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.registry import plugin_errors
from gaitsim.storage.compatibility import expected_genomes, out_of_bounds


def evaluate(
    experiment: str | Path | Experiment,
    genomes: ArrayLike,
    *,
    generation: int = 1,
    repair: bool = True,
) -> Evaluation:
    """Simulate and score genomes, so that any optimiser can use a body and a fitness.

    The scores are bit-identical to those of the same genomes in a run. Higher is better; an
    optimiser that minimises must negate them. A compiled body distributes the population over
    threads; other bodies run in the calling thread. Pass an experiment object to avoid repeated
    setup.

    Args:
        experiment: name of a preset, path of a file, or an experiment; a name or path is read
            again at each call.
        genomes: genomes to evaluate, (population, genes), or (genes,) for one individual; not
            modified.
        generation: generation whose worlds are used, counted from 1, if the experiment has
            several worlds.
        repair: whether to move genes into the genome space as a search does, with
            `experiment.space().repair`: genes are clipped to their bounds, and periodic genes
            wrapped. If False, genes outside the space raise an error.

    Returns:
        The evaluation: `scores` (population,), −inf for an individual that failed; `terms` by
        name, each (population,), which sum to the scores; and `reasons` of failures by the index
        of the individual.

    Raises:
        GaitsimError: the genomes are not finite numbers of the right shape, or outside the genome
            space with `repair=False`; or the experiment does not exist.
        PluginError: the body or the fitness fails or breaks its contract.
    """
    if not isinstance(experiment, Experiment):
        experiment = load_experiment(str(experiment), None, ARGUMENTS)
    whole = isinstance(generation, int | np.integer) and not isinstance(generation, bool)
    if not whole or generation < 1:
        what = f"invalid generation: {generation!r}"
        raise GaitsimError(what, where="generation", allowed="a whole number, 1 or more")
    space = experiment.space()  # called once, as it may be slow
    given = as_genomes(experiment, space, genomes)
    if repair:
        with plugin_errors(experiment.entries["organism"], "repairing genomes"):
            given = np.ascontiguousarray(space.repair(given))
    elif wrong := out_of_bounds(experiment, given, "the population"):
        raise GaitsimError(wrong, where="genomes", remedy="clip the genomes, or omit repair=False")
    return _evaluator(experiment).evaluate(given, int(generation))


def as_genomes(
    experiment: Experiment, space: GenomeSpace, given: ArrayLike, name: str = "genomes"
) -> Genomes:
    """Return genomes as an array (population, genes) with the dtype of the genome space.

    Args:
        experiment: experiment with the body of the genomes.
        space: genome space.
        given: genomes, (population, genes), or one, (genes,).
        name: name of the argument, for messages.
    """
    try:
        array: Any = np.asarray(given)
    except ValueError:  # lists of different lengths
        array = np.empty(0, object)
    if array.dtype.kind not in "fiub":
        raise _invalid_genomes(name, experiment, "the genomes are not real numbers")
    if array.ndim == 1:
        array = array[None]
    if array.ndim != 2 or array.shape[1] != space.genes or not len(array):
        what = f"the genomes have the shape {np.shape(given)}"
        turned = np.shape(given)[:1] == (space.genes,) and np.ndim(given) == 2
        raise _invalid_genomes(name, experiment, what, "transpose them" if turned else "")
    if not np.isfinite(array).all():
        individual, gene = np.argwhere(~np.isfinite(array))[0]
        value = array[individual, gene]
        label = f"gene {gene + 1}, {space.labels[gene]!r},"
        raise _invalid_genomes(name, experiment, f"{label} of individual {individual} is {value}")
    found = np.ascontiguousarray(array, space.dtype)
    if space.dtype.kind != "f" and not np.array_equal(found, array):
        raise _invalid_genomes(name, experiment, f"the genomes are not all of dtype {space.dtype}")
    return found


def _invalid_genomes(
    name: str, experiment: Experiment, what: str, remedy: str = ""
) -> GaitsimError:
    allowed = f"a finite array (population, genes) with {expected_genomes(experiment)}"
    return GaitsimError(what, where=name, allowed=allowed, remedy=remedy)


class _Latest(threading.local):
    """The evaluator of the last call in each thread, kept to reuse its workers."""

    evaluator: Evaluator | None = None


_latest = _Latest()


def _evaluator(experiment: Experiment) -> Evaluator:
    latest = _latest.evaluator
    if latest is not None and latest.experiment is experiment:
        return latest
    if latest is not None:
        latest.__exit__()
    # Worker processes would outlive the call.
    found = Evaluator(experiment, None if experiment.organism.threads else 1)
    _latest.evaluator = found
    return found
