"""Delete a run folder: first atomically from the list, then file by file."""

import shutil
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.opening import is_folder
from gaitsim.runs.background import forget_failure
from gaitsim.runs.files.atomic import writing
from gaitsim.runs.files.drafts import draft_name, locked, remove, sweep
from gaitsim.runs.files.folder import own_run
from gaitsim.runs.files.lock import RunLock


def delete_run(path: Path) -> None:
    """Delete a run with all its exports; links in it are removed, but not their targets.

    Raises:
        RunError: the path is not a run, or is a link to one; another process is writing the run;
            or it cannot be deleted.
    """
    path = own_run(path, "delete")
    sweep(path.parent)
    lock = RunLock(path)
    with writing(path), locked(path):
        try:
            gone = path.rename(draft_name(path.parent))
        finally:
            lock.release()
        forget_failure(path)
        try:
            remove(gone)
            if is_folder(gone):  # repeat it to get the reason
                shutil.rmtree(gone)
        except (OSError, RecursionError) as error:
            nested = "its folders are nested too deeply"
            reason = error.strerror if isinstance(error, OSError) else nested
            raise RunError(
                f"the run {path.name} is removed, but some of its files cannot be deleted: "
                f"{reason}",
                where=str(gone),
                remedy="delete that folder by hand",
            ) from None
