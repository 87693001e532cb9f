"""Fork a run: copy it as of its checkpoint, to continue it under other options."""

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
    kept_champions,
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
    """Copy a run as of its checkpoint, with its champions but without its exports.

    The copy appears at one stroke, with the changed experiment. Another process may write the
    run meanwhile: what it adds after the checkpoint is left out.

    Args:
        path: the run to copy.
        out: the folder to create; None numbers the run's own name. A taken name gets a number.
        overrides: options of the copy's experiment to change, by key; a stage begins with them.
        generations: the last generation of the copy to evolve; None as planned.
        any_version: whether to accept other versions of packages than before.

    Returns:
        The copy's folder.

    Raises:
        ExperimentError: the experiment has problems, or would have them with the overrides.
        RunError: the run is damaged, or the copy cannot be created or resumed.
    """
    run = RunSnapshot(path)
    # The plan reads the checkpoint first: the other files contain all its records by then.
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
        for number in kept_champions(path):
            if number <= checkpoint.generation:
                name = champion_file(number)
                files[name] = pack(read_champion(path / name))
        if entries := read_provenance(path):
            files[PROVENANCE] = provenance_bytes(entries)
    return create_folder(out or path, files, (CHAMPIONS, EXPORTS))
