"""Create runs: from an experiment, from a saved individual, or as a copy of another run."""

import os
import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.evaluation.serialized import prepare
from gaitsim.evaluation.worlds import in_reality
from gaitsim.experiment import Experiment, Overrides, with_overrides
from gaitsim.experiment.loading import parse_experiment
from gaitsim.individual import Member, Which, parse_mark
from gaitsim.opening import read_regular
from gaitsim.registry import plugin_errors
from gaitsim.storage.compatibility import check_size
from gaitsim.storage.files.checkpoint import (
    Champion,
    Start,
    pack,
    read_champion,
)
from gaitsim.storage.files.folder import (
    ALL_SCORES,
    BESTS,
    CHAMPIONS,
    CHECKPOINT,
    CHECKSUMS,
    EXPERIMENT,
    EXPORTS,
    HISTORY,
    ISLANDS,
    MEASURES,
    PROVENANCE,
    RUNS,
    SAVES,
    START,
    champion_file,
    champion_generations,
    create_folder,
    find_run,
)
from gaitsim.storage.files.safe_pickle import MAX_BYTES
from gaitsim.storage.files.tables import first_rows
from gaitsim.storage.provenance import provenance_bytes, read_provenance
from gaitsim.storage.resume import plan_resume
from gaitsim.storage.snapshot import RunSnapshot


def create_run(
    experiment: Experiment, out: Path | None = None, start: Champion | Start | None = None
) -> Path:
    """Create the folder of a new run; a number is added to an existing name, as in spider-2.

    The folder is created atomically, with its experiment.

    Args:
        experiment: experiment, which is written to the folder in resolved form.
        out: folder to create; None for `runs/<name of the experiment>`.
        start: individual or genomes that fit the experiment's body, around which the first
            generation is drawn; None uses the start points that `search.start` chooses.
    """
    experiment.check_functions()
    check_size(experiment)
    if experiment.search.reads():
        prepare(experiment)  # raises an error for unknown terms and measures
    if experiment.reality is not None:
        prepare(in_reality(experiment))  # raises an error if the reality cannot be simulated
    wanted = RUNS / experiment.name if out is None else out
    files: dict[str, str | bytes | Iterable[bytes]] = {EXPERIMENT: experiment.to_toml()}
    if start is not None:
        files[START] = pack(start)
    return create_folder(wanted, files, (CHAMPIONS, EXPORTS))


ALLOWED = (
    "a champion file, as in runs/spider/champions; a run, for its champion; RUN@GENERATION, "
    "for the best individual of a generation; RUN@GENERATION:NUMBER, for any individual; or "
    "RUN#MEMBER, for a member of its front or archive"
)


def find_individual(reference: str) -> Champion:
    """Return the individual that a champion file or a reference as in `ALLOWED` names."""
    # Unlike pathlib, os.path does not raise an error for an invalid file name.
    if os.path.exists(reference) and not os.path.isdir(reference):  # noqa: PTH110, PTH112
        return read_champion(Path(reference).resolve())  # links named by the user are followed
    if parts := re.fullmatch(
        r"(.*)(?:@([0-9]{1,9}(?::(?:[0-9]{1,9}|centre))?)|#([0-9]{1,9}))", reference, re.DOTALL
    ):
        run, place, member = parts.groups()
        which = Member(int(member)) if member else parse_mark(place)
        try:  # the name of a run may itself end with @ or # and a number
            path = find_run(reference)
        except RunError:
            return champion_of(_find_snapshot(run), which)
        return champion_of(RunSnapshot(path))
    return champion_of(_find_snapshot(reference))


def without_symmetry(experiment: Experiment, start: Champion) -> Champion:
    """Return a start for an experiment whose legs share no genes; other starts are unchanged."""
    free = getattr(experiment.organism, "symmetry", "") == "none"
    if not free or len(start.genome) == experiment.space().genes:
        return start
    found = parse_experiment(start.experiment, "--from")
    with plugin_errors(found.entries["organism"], "unfolding a genome"):
        genomes = found.organism.unfold(start.genome[None])
    if genomes is None:
        return start
    unfolded = with_overrides(found, {"organism.symmetry": "none"})
    genome = unfolded.space().repair(genomes)[0]
    return replace(start, experiment=unfolded.to_toml(), genome=genome)


def _find_snapshot(run: str) -> RunSnapshot:
    try:
        return RunSnapshot.find(run)
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


def fork_run(
    path: Path,
    out: Path | None = None,
    overrides: Overrides | None = None,
    *,
    generations: int | None = None,
    any_version: bool = False,
) -> Path:
    """Copy a run up to its checkpoint, with its champions but without its exports.

    The copy is created atomically, with the changed experiment. Another process may be writing
    the run; records after the checkpoint are left out.

    Args:
        path: folder of the run to copy.
        out: folder to create; None for the run's name. A number is added to an existing name.
        overrides: options to change in the copy's experiment, by key.
        generations: last generation of the copy; None for the number in the experiment.
        any_version: whether to accept package versions other than those of the run.

    Returns:
        The folder of the copy.
    """
    run = RunSnapshot(path)
    # The plan reads the checkpoint first: the files, read later, then contain all its records.
    plan = plan_resume(run, overrides, generations=generations, any_version=any_version)
    files: dict[str, str | bytes | Iterable[bytes]] = {
        EXPERIMENT: plan.experiment.to_toml() if plan.edited else run.experiment_text
    }
    checkpoint = run.checkpoint
    if run.start is not None:
        files[START] = read_regular(path / START, MAX_BYTES)
    if checkpoint is not None:
        files |= {BESTS: run.bests.tobytes(), CHECKSUMS: run.checksums.tobytes()}
        numbers = range(1, checkpoint.generation + 1)
        files[ALL_SCORES] = (run.score_block(number) for number in numbers)
        files[SAVES] = run.saves[run.saves <= checkpoint.generation].tobytes()
        files[CHECKPOINT] = pack(checkpoint)
        for name in (HISTORY, ISLANDS) if run.islands.shape[1] > 1 else (HISTORY,):
            files[name] = first_rows(path / name, checkpoint.generation)
        for number in champion_generations(path, checkpoint.generation):
            name = champion_file(number)
            files[name] = pack(read_champion(path / name))
        if os.path.lexists(path / MEASURES):
            files[MEASURES] = read_regular(path / MEASURES, MAX_BYTES)
        if entries := read_provenance(path):
            files[PROVENANCE] = provenance_bytes(entries)
    return create_folder(out or path, files, (CHAMPIONS, EXPORTS))
