"""Delete a run folder: rename it atomically, then delete its files."""

import shutil
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.opening import is_folder
from gaitsim.runs.background import forget_failure
from gaitsim.runs.files.atomic import writing
from gaitsim.runs.files.drafts import draft_name, locked, remove, sweep
from gaitsim.runs.files.folder import resolve_run
from gaitsim.runs.files.lock import RunLock


def delete_run(path: Path) -> None:
    """Delete a run with all its exports; links in it are removed, but not their targets."""
    path = resolve_run(path, "delete")
    sweep(path.parent)
    lock = RunLock(path)
    with writing(path), locked(path):
        try:
            draft = path.rename(draft_name(path.parent))
        finally:
            lock.release()
        forget_failure(path)
        try:
            remove(draft)
            if is_folder(draft):  # repeat the deletion to get the reason for its failure
                shutil.rmtree(draft)
        except (OSError, RecursionError) as error:
            nested = "its folders are nested too deeply"
            reason = error.strerror if isinstance(error, OSError) else nested
            raise RunError(
                f"the run {path.name} was removed, but some of its files could not be deleted: "
                f"{reason}",
                where=str(draft),
                remedy="delete that folder by hand",
            ) from None
