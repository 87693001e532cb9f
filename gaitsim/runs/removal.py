"""A run folder is deleted: out of the list at one stroke, then file by file."""

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
    """Delete a run with all that was made of it; links in it are removed, not their targets.

    Raises:
        RunError: it is not a run, or a link to one; another process writes it; or it cannot be
            deleted.
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
            if is_folder(gone):  # again, for the reason
                shutil.rmtree(gone)
        except (OSError, RecursionError) as error:
            reason = error.strerror if isinstance(error, OSError) else "its folders are too deep"
            raise RunError(
                f"the run {path.name} is gone, but some of its files cannot be deleted: {reason}",
                where=str(gone),
                remedy="delete that folder by hand",
            ) from None
