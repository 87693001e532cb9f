"""Saved views of lists of runs: `views.toml` beside the settings of the user."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gaitsim import toml
from gaitsim.errors import GaitsimError, unknown
from gaitsim.opening import read_regular
from gaitsim.storage.files.atomic import write_bytes, writing
from gaitsim.storage.query import parse_query

if TYPE_CHECKING:
    from tomlkit import TOMLDocument

LARGEST = 1_000_000  # bytes


@dataclass(frozen=True)
class View:
    """A view of a list of runs.

    Attributes:
        name: name of the view.
        where: query of the runs.
        columns: keys of the columns; () for the usual ones.
        sort: key to sort by, with `-` for descending order; '' for the usual order.
        group: key to group by; '' for none.
    """

    name: str
    where: str = ""
    columns: tuple[str, ...] = ()
    sort: str = ""
    group: str = ""


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


def views_path() -> Path:
    """Return the path of the saved views, existing or not."""
    return config_folder() / "views.toml"


def read_views() -> tuple[dict[str, View], dict[str, GaitsimError]]:
    """Return the saved views, and the problems of invalid ones, by name.

    Raises:
        GaitsimError: the file cannot be read, or is not valid TOML.
    """
    path = views_path()
    views, problems = {}, {}
    for name, table in toml.parse(read_settings(path), str(path)).items():
        try:
            views[name] = _view(name, table)
        except GaitsimError as error:
            problems[name] = error
    return views, problems


def find_view(name: str) -> View:
    """Return a saved view."""
    views, problems = read_views()
    if name in problems:
        raise problems[name]
    if name not in views:
        error = unknown("view", name, views, where=str(views_path()))
        error.allowed = error.allowed or "none; save one with 'gaitsim runs --save-view NAME'"
        raise error
    return views[name]


def save_view(view: View) -> None:
    """Save a view, which replaces the one of the same name."""
    if not view.name.strip() or not view.name.isprintable() or len(view.name) > 100:
        raise GaitsimError(
            f"invalid name of a view: {view.name!r:.100}", allowed="1 to 100 printable characters"
        )
    parse_query(view.where)
    values = {key: value for key, value in asdict(view).items() if value and key != "name"}
    values |= {"columns": [*view.columns]} if view.columns else {}
    with editing(views_path()) as document:
        document.pop(view.name, None)
        document[view.name] = values


def forget_view(name: str) -> None:
    """Delete a saved view."""
    if name not in read_views()[1]:  # an invalid view can be deleted, too
        find_view(name)
    with editing(views_path()) as document:
        document.pop(name, None)


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


def _view(name: str, table: Any) -> View:
    path = views_path()
    where = f"{path}, view {name!r}"
    if not isinstance(table, dict):
        raise GaitsimError(
            f"{toml.shortened(name)!r} is not a view", where=str(path), allowed="sections [NAME]"
        )
    known = [one.name for one in fields(View)][1:]
    for key, value in table.items():
        if key not in known:
            raise unknown("key", key, known, where=where)
        right = isinstance(value, list) if key == "columns" else isinstance(value, str)
        if not right or not all(isinstance(one, str) for one in value):
            allowed = "a list of keys" if key == "columns" else "a text"
            raise GaitsimError(
                f"invalid {key}: {toml.literal(value)}", where=where, allowed=allowed
            )
    found = View(name, **{**table, "columns": tuple(table.get("columns", ()))})
    try:
        parse_query(found.where)
    except GaitsimError as error:
        error.where = where
        raise
    return found
