"""A copy of a run that goes its own way from where the run stands."""

import os
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.experiment import Overrides
from gaitsim.runs.files import history
from gaitsim.runs.files.checkpoint import pack
from gaitsim.runs.files.checksums import RECORD
from gaitsim.runs.files.folder import (
    BESTS,
    CHAMPIONS,
    CHECKPOINT,
    CHECKSUMS,
    EXPERIMENT,
    EXPORTS,
    HISTORY,
    ISLANDS,
    PROVENANCE,
    START,
    champion_file,
    create_folder,
    ends_early,
    kept_champions,
)
from gaitsim.runs.resume import plan_resume
from gaitsim.runs.snapshot import RunSnapshot


def fork_run(
    path: Path,
    out: Path | None = None,
    overrides: Overrides | None = None,
    *,
    generations: int | None = None,
    any_version: bool = False,
) -> Path:
    """Copy a run as of its checkpoint, its champions with it but no exports.

    The copy appears at one stroke, its experiment changed already. The run may be written by
    another process meanwhile: what it adds after the checkpoint is left out.

    Args:
        path: the run to copy.
        out: the folder to make; None numbers the run's own name. A taken name gets a number.
        overrides: options of the copy's experiment to change, by key; a stage begins with them.
        generations: how far the copy is to go; None as far as planned.
        any_version: whether other versions of packages than before will do.

    Returns:
        The copy's folder.

    Raises:
        ExperimentError: the experiment has problems, or would have them with the overrides.
        RunError: the run is damaged, or the copy cannot be created or resumed.
    """
    run = RunSnapshot(path)
    # It reads the checkpoint first: all that it counts is in the other files by then.
    plan = plan_resume(run, overrides, generations=generations, any_version=any_version)
    changed = bool(overrides) or generations is not None
    files: dict[str, str | bytes] = {
        EXPERIMENT: plan.experiment.to_toml() if changed else run.experiment_text
    }
    checkpoint = run.checkpoint
    if checkpoint is not None:
        files |= _records(run, checkpoint.generation) | _champions(path, checkpoint.generation)
        files[CHECKPOINT] = pack(checkpoint)
        size = RECORD.itemsize * checkpoint.generation
        files |= {name: data[:size] for name, data in _optional(path, CHECKSUMS)}
        files |= dict(_optional(path, PROVENANCE))
        for name, data in _optional(path, ISLANDS):
            lines = data.splitlines(keepends=True)[: 1 + checkpoint.generation]
            files[name] = b"".join(lines)
    files |= dict(_optional(path, START))
    return create_folder(out or path, files, (CHAMPIONS, EXPORTS))


def _optional(path: Path, name: str) -> list[tuple[str, bytes]]:
    """A file that not every run has, and its name."""
    return [(name, _read(path / name))] if os.path.lexists(path / name) else []


def _records(run: RunSnapshot, generations: int) -> dict[str, bytes]:
    """The files of records, cut after those of so many generations."""
    rows = _read(run.path / HISTORY).splitlines(keepends=True)[: 1 + generations]
    size = history.record_type(run.experiment.space()).itemsize
    bests = _read(run.path / BESTS)[: size * generations]
    for name, stored in ((HISTORY, len(rows) - 1), (BESTS, len(bests) // size)):
        if stored < generations:
            raise ends_early(run.path, name, max(stored, 0), generations)
    return {HISTORY: b"".join(rows), BESTS: bests}


def _champions(path: Path, generations: int) -> dict[str, bytes]:
    """The champions of so many generations by their place in the run's folder."""
    return {
        champion_file(number): _read(path / champion_file(number))
        for number in kept_champions(path)
        if number <= generations
    }


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise RunError(
            f"cannot read {path}: {error.strerror}",
            remedy="restore all files of the run from one copy",
        ) from None
