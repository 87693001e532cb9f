"""Scores of genomes for any optimiser: `gaitsim.evaluate`."""

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
from gaitsim.runs.compatibility import expected_genomes, out_of_bounds


def evaluate(
    experiment: str | Path | Experiment,
    genomes: ArrayLike,
    *,
    generation: int = 1,
    repair: bool = True,
) -> Evaluation:
    """Move and score genomes, so that any optimiser can use a body and a fitness.

    Scores are those of the same genomes in a run, to the bit. More is better: an optimiser that
    minimises takes their negative. A compiled body shares the population among threads, any other
    is moved by the calling thread. With an experiment object nothing is set up again for the next
    call.

    Args:
        experiment: a preset's name, the path of a file, or an experiment; a name or a path is
            read again in every call.
        genomes: (population, genes), or (genes,) for one individual; left unchanged.
        generation: in whose worlds, from 1, where the experiment has several.
        repair: whether genes outside the genome space are brought into it as in a search, by
            `experiment.space().repair`: clipped to their bounds, angles of a cycle wrapped.
            Otherwise they are refused.

    Returns:
        `scores` (population,), −inf for an individual that failed; `terms`, whose sum they are, by
        name, each (population,); and `reasons` of failures by the individual's index.

    Raises:
        GaitsimError: the genomes are no finite numbers of the right shape, or outside the genome
            space and not to be repaired; or there is no such experiment.
        PluginError: the body or the fitness fails or breaks its contract.
    """
    if not isinstance(experiment, Experiment):
        experiment = load_experiment(str(experiment), None, ARGUMENTS)
    whole = isinstance(generation, int | np.integer) and not isinstance(generation, bool)
    if not whole or generation < 1:
        what = f"{generation!r} is not the number of a generation"
        raise GaitsimError(what, where="generation", allowed="a whole number, 1 or more")
    space = experiment.space()  # once, as a body may take long to describe it
    given = _genomes(experiment, space, genomes)
    if repair:
        with plugin_errors(experiment.entries["organism"], "repairing genomes"):
            given = np.ascontiguousarray(space.repair(given))
    elif wrong := out_of_bounds(experiment, given, "the population"):
        raise GaitsimError(wrong, where="genomes", remedy="clip them, or leave repair=False out")
    return _evaluator(experiment).evaluate(given, int(generation))


def _genomes(experiment: Experiment, space: GenomeSpace, given: ArrayLike) -> Genomes:
    """Return genomes (population, genes) in the dtype of the experiment's space.

    Raises:
        GaitsimError: they cannot be that.
    """
    try:
        array: Any = np.asarray(given)
    except ValueError:  # lists of different lengths
        array = np.empty(0, object)
    if array.dtype.kind not in "fiub":
        raise _refused(experiment, "the genomes are not real numbers")
    if array.ndim == 1:
        array = array[None]
    if array.ndim != 2 or array.shape[1] != space.genes or not len(array):
        what = f"the genomes have the shape {np.shape(given)}"
        turned = np.shape(given)[:1] == (space.genes,) and np.ndim(given) == 2
        raise _refused(experiment, what, "transpose them" if turned else "")
    if not np.isfinite(array).all():
        individual, gene = np.argwhere(~np.isfinite(array))[0]
        value = array[individual, gene]
        label = f"gene {gene + 1}, {space.labels[gene]!r},"
        raise _refused(experiment, f"{label} of individual {individual} is {value}")
    found = np.ascontiguousarray(array, space.dtype)
    if space.dtype.kind != "f" and not np.array_equal(found, array):
        raise _refused(experiment, f"the genomes are not all of dtype {space.dtype}")
    return found


def _refused(experiment: Experiment, what: str, remedy: str = "") -> GaitsimError:
    allowed = f"(population, genes), finite: {expected_genomes(experiment)}"
    return GaitsimError(what, where="genomes", allowed=allowed, remedy=remedy)


class _Latest(threading.local):
    """The evaluator of a thread's last call, whose threads serve the next one."""

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
