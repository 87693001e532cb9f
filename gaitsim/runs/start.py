"""Warm starts: runs that start from a saved individual instead of a random population."""

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
    "a champion file, as in runs/spider/champions; a run, for its champion; RUN@GENERATION, "
    "for the best individual of a generation; or RUN#MEMBER, for a member of its front or archive"
)


def find_individual(reference: str) -> Champion:
    """Return the individual named by a champion file, a run, RUN@GENERATION or RUN#MEMBER."""
    # Unlike pathlib, os.path does not raise an error for an invalid file name.
    if os.path.exists(reference) and not os.path.isdir(reference):  # noqa: PTH110, PTH112
        return read_champion(Path(reference).resolve())  # links named by the user are followed
    if parts := re.fullmatch(r"(.*)([@#])([0-9]{1,9})", reference, re.DOTALL):
        run, mark, number = parts[1], parts[2], int(parts[3])
        try:  # the name of a run may itself end with @ or # and a number
            path = find_run(reference)
        except RunError:
            return champion_of(_find_snapshot(run), number if mark == "@" else Member(number))
        return champion_of(RunSnapshot(path))
    return champion_of(_find_snapshot(reference))


def _find_snapshot(run: str) -> RunSnapshot:
    try:
        return RunSnapshot(find_run(run))
    except RunError as error:
        error.where = error.where or "--from"
        error.remedy = f"give {ALLOWED}"
        raise


def champion_of(run: RunSnapshot, which: Which = None) -> Champion:
    """Return the champion, the best of a generation or a member, as a champion file stores it."""
    individual = run.individual(which)
    stage, genome = run.stage_at(individual.generation), individual.genome
    if genome is None:
        raise ValueError("the individual has no genome")
    return Champion(
        experiment=stage.experiment,
        versions=dict(stage.versions),
        generation=individual.generation,
        genome=genome,
        score=individual.score,
        terms=dict(individual.terms),
    )


def check_start(experiment: Experiment, start: Champion, where: str) -> None:
    """Check that the genome of an individual fits the experiment's body."""
    wrong = genome_mismatch(experiment, start.genome[None], start.experiment, "the genome")
    if wrong:
        raise RunError(
            f"{wrong}, so a run cannot start from it",
            where=where,
            allowed=expected_genomes(experiment),
            remedy="start from an individual of the same body, with the same options for its "
            "genome",
        )


def start_genome(run: RunSnapshot, experiment: Experiment) -> Array | None:
    """Return the genome of the initial population, (genes,); None for a random population."""
    try:
        start = run.start
    except CheckpointError as error:
        error.remedy = "restore it from a copy; the run cannot start as planned without it"
        raise
    if start is None:
        return None
    check_start(experiment, start, str(run.path / START))
    return start.genome
