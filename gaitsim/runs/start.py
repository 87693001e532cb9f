"""A run that begins with a kept individual instead of a population that is drawn."""

import os
import re
from pathlib import Path

from gaitsim.contracts import Array
from gaitsim.errors import CheckpointError, RunError
from gaitsim.experiment import Experiment
from gaitsim.individual import Member, Which
from gaitsim.runs.compatibility import expected_genomes, genome_mismatch
from gaitsim.runs.files.checkpoint import Champion, read_champion
from gaitsim.runs.files.folder import START, find_run
from gaitsim.runs.snapshot import RunSnapshot

ALLOWED = (
    "a champion's file, as in runs/spider/champions; a run, for its champion; RUN@GENERATION, "
    "for that generation's best; or RUN#MEMBER, for a member of its front or archive"
)


def kept_individual(reference: str) -> Champion:
    """The individual that a user names: a champion's file, a run, RUN@GENERATION or RUN#MEMBER.

    Raises:
        CheckpointError: the file is not a champion's, is damaged, or hostile.
        RunError: there is no such file, run, generation or member, or it has no champion.
    """
    # os.path, unlike pathlib, answers for names that no file can have, too.
    if os.path.exists(reference) and not os.path.isdir(reference):  # noqa: PTH110, PTH112
        return read_champion(Path(reference).resolve())  # the link of a user is theirs
    if parts := re.fullmatch(r"(.*)([@#])([0-9]{1,9})", reference, re.DOTALL):
        run, mark, number = parts[1], parts[2], int(parts[3])
        try:  # for a run whose name ends so
            path = find_run(reference)
        except RunError:
            return champion_of(_found(run), number if mark == "@" else Member(number))
        return champion_of(RunSnapshot(path))
    return champion_of(_found(reference))


def _found(run: str) -> RunSnapshot:
    try:
        return RunSnapshot(find_run(run))
    except RunError as error:
        error.where = error.where or "--from"
        error.remedy = f"give {ALLOWED}"
        raise


def champion_of(run: RunSnapshot, which: Which = None) -> Champion:
    """A run's champion, a generation's or a member, as its file would hold it.

    Raises:
        RunError: there is no such generation or member, or it has no champion.
    """
    individual = run.individual(which)
    stage, genome = run.stage_at(individual.generation), individual.genome
    if genome is None:
        raise ValueError("an individual of a run has a genome")
    return Champion(
        experiment=stage.experiment,
        versions=dict(stage.versions),
        generation=individual.generation,
        genome=genome,
        score=individual.score,
        terms=dict(individual.terms),
    )


def check_start(experiment: Experiment, start: Champion, where: str) -> None:
    """Check that an individual's genome is one of the experiment's body.

    Raises:
        RunError: it is not; says what was expected and what came.
    """
    wrong = genome_mismatch(experiment, start.genome[None], start.experiment, "the genome")
    if wrong:
        raise RunError(
            f"{wrong}, so a run cannot start from it",
            where=where,
            allowed=expected_genomes(experiment),
            remedy="start from an individual of the same body, with the same options that shape "
            "the genome",
        )


def start_genome(run: RunSnapshot, experiment: Experiment) -> Array | None:
    """The genome, (genes,), that the run's initial population is to be made of; None draws it.

    Raises:
        CheckpointError: its file is damaged or hostile.
        RunError: it does not fit the experiment.
    """
    try:
        start = run.start
    except CheckpointError as error:
        error.remedy = "restore it from a copy; without it, this run cannot begin as it was meant"
        raise
    if start is None:
        return None
    check_start(experiment, start, str(run.path / START))
    return start.genome
