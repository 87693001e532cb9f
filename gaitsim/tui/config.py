"""The user's settings: `config.toml` with a theme, notifications, and keys by action.

Invalid settings are reported and ignored; the valid ones apply.
"""

import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from string import punctuation
from typing import Annotated, Any

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    StrictBool,
    StringConstraints,
    ValidationError,
)
from textual.keys import KEY_NAME_REPLACEMENTS, Keys

from gaitsim.errors import GaitsimError, nearest
from gaitsim.storage.settings import config_folder, editing, read_settings
from gaitsim.toml import literal, parse
from gaitsim.tui.keys import NAMED
from gaitsim.tui.themes import check_theme

THEME = "theme"
MODIFIERS = {"ctrl", "shift", "alt", "meta", "super", "hyper"}
KEYS = (
    frozenset(key.value.rpartition("+")[2] for key in Keys)
    | {unicodedata.name(sign).lower().replace(" ", "_").replace("-", "_") for sign in punctuation}
    | {*KEY_NAME_REPLACEMENTS.values()}
)


@dataclass(frozen=True)
class Config:
    """The settings of a user.

    Attributes:
        path: settings file.
        theme: name of the chosen theme; None without a choice.
        notify: whether the end of a background run rings the bell and notifies the desktop.
        preview: whether home shows the champion under the cursor, if there is room.
        columns: keys of the columns of the list of runs; () for the usual ones.
        sort: key to sort the runs by, with `-` for descending order; '' for the latest first.
        keys: keys by the ID of their action, such as `ctrl+d` for `home.delete`.
        problems: problems of the file.
    """

    path: Path
    theme: str | None = None
    notify: bool = True
    preview: bool = True
    columns: tuple[str, ...] = ()
    sort: str = ""
    keys: Mapping[str, str] = field(default_factory=dict)
    problems: tuple[GaitsimError, ...] = ()


def _flatten(table: Any) -> Any:
    """Flatten tables to dotted keys, because TOML parses `home.delete = …` as nested tables."""
    if not isinstance(table, dict):
        return table
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            flat |= {f"{key}.{name}": one for name, one in _flatten(value).items()}
        else:
            flat[key] = value
    return flat


Key = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class _Tui(BaseModel):
    model_config = ConfigDict(extra="forbid")
    theme: str | None = None
    notify: StrictBool = True
    preview: StrictBool = True
    columns: tuple[str, ...] = ()
    sort: str = ""


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid")
    tui: _Tui = _Tui()
    keys: Annotated[dict[str, Key], BeforeValidator(_flatten)] = {}


_ALLOWED = {
    "tui": "a section [tui]",
    "keys": "a section [keys]",
    "tui.theme": "the name of a theme in quotes",
    "tui.notify": "true or false",
    "tui.preview": "true or false",
    "tui.columns": "a list of keys",
    "tui.sort": "a key in quotes",
}


def config_path() -> Path:
    """Return the path of the settings in $XDG_CONFIG_HOME or ~/.config, existing or not."""
    return config_folder() / "config.toml"


def read_config(path: Path) -> Config:
    """Read the valid settings in a file, and its problems."""
    try:
        data = parse(read_settings(path), str(path))
    except GaitsimError as error:
        return Config(path, problems=(error,))
    data |= {"keys": _flatten(data["keys"])} if "keys" in data else {}
    problems = []
    try:
        found = _File.model_validate(data)
    except ValidationError as error:
        for detail in error.errors(include_url=False):
            *sections, name = (str(part) for part in detail["loc"])
            problems.append(_problem(path, sections, name, detail))
            (data[sections[0]] if sections else data).pop(name)
        found = _File.model_validate(data)
    theme = found.tui.theme
    try:
        theme = theme and check_theme(theme, where=f"{path}, key tui.{THEME}", key=f"tui.{THEME}")
    except GaitsimError as error:
        problems.append(error)
        theme = None
    tui = found.tui
    values = {**dict(tui), "theme": theme}
    return Config(path, **values, keys=found.keys, problems=tuple(problems))


def _problem(path: Path, sections: list[str], name: str, detail: Any) -> GaitsimError:
    key = ".".join([*sections, name])
    where = f"{path}, key {key}"
    if detail["type"] == "extra_forbidden":
        known = list((_Tui if sections else _File).model_fields)
        what, hint = f"unknown key {literal(name)}", nearest(name, known)
        return GaitsimError(what, where=where, allowed=", ".join(known), remedy=hint, key=key)
    allowed = _ALLOWED.get(key, 'a key in quotes, such as "ctrl+d"')
    what = f"invalid {key}: {literal(detail['input'])}"
    return GaitsimError(what, where=where, allowed=allowed, key=key)


def remember(path: Path, key: str, value: str | bool | list[str]) -> None:
    """Write a key of [tui] to the settings; keep the rest of the file, including comments."""
    with editing(path) as document:
        tui = document.setdefault("tui", {})
        if not isinstance(tui, dict):
            raise GaitsimError("'tui' must be a section, written as [tui]", where=str(path))
        tui[key] = value


def format_problem(problem: GaitsimError) -> str:
    """Return a problem of the settings on one line, with its key and a remedy."""
    place = problem.key or problem.where
    what = problem.what if place in problem.what else f"{place}: {problem.what}"
    remedy = problem.remedy or (problem.allowed and f"allowed: {problem.allowed}")
    return f"• {what}; {remedy}" if remedy else f"• {what}"


def valid_keys(config: Config) -> dict[str, str]:
    """Return the valid keys of the settings by ID; other IDs keep their default keys."""
    chosen = {
        name: [key.strip() for key in text.split(",") if is_key(key.strip())]
        for name, text in config.keys.items()
    }
    return {name: ",".join(keys) for name, keys in chosen.items() if keys}


def check_keys(config: Config) -> list[GaitsimError]:
    """Return the problems of the chosen keys: unknown IDs, and keys that do not exist."""
    found = []
    for name, chosen in config.keys.items():
        place = {"where": f"{config.path}, key keys.{name}", "key": f"keys.{name}"}
        if name not in NAMED:
            remedy = nearest(name, sorted(NAMED)) or "press ? on a screen to list its IDs"
            found.append(GaitsimError(f"unknown ID {literal(name)}", remedy=remedy, **place))
        for key in chosen.split(","):
            if not is_key(key.strip()):
                bare = key.strip().rpartition("+")[2]
                found.append(
                    GaitsimError(
                        f"there is no key {literal(key.strip())}",
                        allowed='a character, or a name such as "enter", "f5" or "ctrl+d"',
                        remedy=nearest(bare, sorted(KEYS)),
                        **place,
                    )
                )
    return found


def is_key(key: str) -> bool:
    """Return whether a name is that of a key, such as 'x', 'enter' or 'ctrl+d'."""
    if len(key) == 1:
        return True
    *modifiers, bare = key.split("+")
    return {*modifiers} <= MODIFIERS and (len(bare) == 1 or bare in KEYS)
