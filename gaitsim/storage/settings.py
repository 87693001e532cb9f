"""Files of the user's settings."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsim import toml
from gaitsim.errors import GaitsimError
from gaitsim.opening import read_regular
from gaitsim.storage.files.atomic import write_bytes, writing

if TYPE_CHECKING:
    from tomlkit import TOMLDocument

LARGEST = 1_000_000  # bytes


def config_folder() -> Path:
    """Return the folder of the user's settings in $XDG_CONFIG_HOME or ~/.config."""
    return user_folder("XDG_CONFIG_HOME", ".config")


def user_folder(variable: str, default: str) -> Path:
    """Return the folder of gaitsim in the one that a variable of the XDG specification names.

    Args:
        variable: name of the variable.
        default: folder in the user's home that replaces it.
    """
    given = Path(os.environ.get(variable, ""))
    # The specification requires relative paths to be ignored.
    return (given if given.is_absolute() else Path.home() / default) / "gaitsim"


@contextmanager
def editing(path: Path) -> Iterator["TOMLDocument"]:
    """Yield a settings file for changes, which keep the rest of the file and its comments."""
    import tomlkit

    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    text = read_settings(path)
    toml.parse(text, str(path))
    document = tomlkit.parse(text)
    yield document
    write_bytes(path, tomlkit.dumps(document).encode())


def read_settings(path: Path) -> str:
    """Return the text of a settings file; '' if it does not exist."""
    try:
        return read_regular(path, LARGEST, follow=True).decode("utf-8-sig")
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise GaitsimError(f"cannot read {path}: {reason}") from None
