"""Create the folder of a new run."""

from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.evaluation.serialized import prepare
from gaitsim.evaluation.worlds import in_reality
from gaitsim.experiment import Experiment
from gaitsim.runs.files.checkpoint import Champion, pack
from gaitsim.runs.files.folder import CHAMPIONS, EXPERIMENT, EXPORTS, RUNS, START, create_folder
from gaitsim.runs.files.safe_pickle import MAX_BYTES


def create_run(
    experiment: Experiment, out: Path | None = None, start: Champion | None = None
) -> Path:
    """Create the folder of a new run; a number is added to an existing name, as in spider-2.

    The folder is created atomically, with its experiment.

    Args:
        experiment: experiment, which is written to the folder in resolved form.
        out: folder to create; None for `runs/<name of the experiment>`.
        start: individual that fits the experiment's body, from which the initial population is
            built; None draws the population at random.
    """
    experiment.check_functions()
    check_size(experiment)
    if experiment.search.reads():
        prepare(experiment)  # raises an error for unknown terms and measures
    if experiment.reality is not None:
        prepare(in_reality(experiment))  # raises an error if the reality cannot be simulated
    wanted = RUNS / experiment.name if out is None else out
    files: dict[str, str | bytes] = {EXPERIMENT: experiment.to_toml()}
    if start is not None:
        files[START] = pack(start)
    return create_folder(wanted, files, (CHAMPIONS, EXPORTS))


def check_size(experiment: Experiment) -> None:
    """Check that the population fits into a checkpoint."""
    population, space = experiment.individuals, experiment.space()
    # Half of the checkpoint is reserved for scores and terms.
    most = MAX_BYTES // 2 // (space.genes * space.dtype.itemsize)
    if population > most:
        raise RunError(
            f"{population:,} individuals with {space.genes} genes are too many for a checkpoint",
            allowed=f"evolution.population up to {most // experiment.islands.number:,}",
        )
