"""The note of a run: a text by the user, stored in the run's folder."""

from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.opening import read_regular
from gaitsim.runs.files.atomic import sync_folder, write_bytes, writing
from gaitsim.runs.files.folder import NOTE, find_run

LARGEST = 50_000  # bytes


def read_note(run: Path) -> str:
    """Return the note of a run; '' without one."""
    path = run / NOTE
    try:
        return read_regular(path, LARGEST).decode().strip()
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not a text file in UTF-8"
        raise RunError(
            f"cannot read {path}: {reason}",
            remedy="delete the file, or write the note again with 'gaitsim note'",
        ) from None


def write_note(run: Path, text: str) -> None:
    """Replace the note of a run, which may be evolving; '' removes the note."""
    path = find_run(str(run)) / NOTE
    text = "\n".join(text.splitlines()).strip()
    try:
        data = f"{text}\n".encode()
    except UnicodeEncodeError:
        raise RunError("the note has invalid characters", allowed="UTF-8") from None
    if len(data) > LARGEST:
        raise RunError(
            f"the note is too long: {len(data):,} bytes", allowed=f"up to {LARGEST:,} bytes"
        )
    if text:
        write_bytes(path, data, follow=False)
        return
    with writing(path):
        path.unlink(missing_ok=True)
        sync_folder(path.parent)
