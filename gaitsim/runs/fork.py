"""Fork a run: copy it up to its checkpoint, to continue the copy with other options."""

from pathlib import Path

from gaitsim.experiment import Overrides
from gaitsim.runs.files.checkpoint import pack, read_champion
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
    saved_champions,
)
from gaitsim.runs.files.provenance import provenance_bytes, read_provenance
from gaitsim.runs.files.tables import first_rows
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
    changed = bool(overrides) or generations is not None
    files: dict[str, str | bytes] = {
        EXPERIMENT: plan.experiment.to_toml() if changed else run.experiment_text
    }
    checkpoint = run.checkpoint
    if run.start is not None:
        files[START] = pack(run.start)
    if checkpoint is not None:
        files |= {BESTS: run.bests.tobytes(), CHECKSUMS: run.checksums.tobytes()}
        files[CHECKPOINT] = pack(checkpoint)
        for name in (HISTORY, ISLANDS) if run.islands.shape[1] > 1 else (HISTORY,):
            files[name] = first_rows(path / name, checkpoint.generation)
        for number in saved_champions(path):
            if number <= checkpoint.generation:
                name = champion_file(number)
                files[name] = pack(read_champion(path / name))
        if entries := read_provenance(path):
            files[PROVENANCE] = provenance_bytes(entries)
    return create_folder(out or path, files, (CHAMPIONS, EXPORTS))
