"""The user's settings: `config.toml` with a theme and keys.

Invalid settings are reported and ignored; the valid ones apply.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, StringConstraints, ValidationError

from gaitsim.errors import GaitsimError, nearest
from gaitsim.opening import read_regular
from gaitsim.toml import literal, parse
from gaitsim.tui.themes import check_theme

THEME = "theme"
LARGEST = 1_000_000  # bytes


@dataclass(frozen=True)
class Config:
    """The settings of a user.

    Attributes:
        path: settings file.
        theme: name of the chosen theme; None without a choice.
        keys: keys by the ID of their action, such as `ctrl+d` for `home.delete`.
        problems: problems of the file.
    """

    path: Path
    theme: str | None = None
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


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid")
    tui: _Tui = _Tui()
    keys: Annotated[dict[str, Key], BeforeValidator(_flatten)] = {}


_ALLOWED = {
    "tui": "a section [tui]",
    "keys": "a section [keys]",
    "tui.theme": "the name of a theme in quotes",
}


def config_path() -> Path:
    """Return the path of the settings in $XDG_CONFIG_HOME or ~/.config, existing or not."""
    home = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    # The XDG specification requires relative paths to be ignored.
    folder = home if home.is_absolute() else Path.home() / ".config"
    return folder / "gaitsim" / "config.toml"


def read_config(path: Path) -> Config:
    """Read the valid settings in a file, and its problems."""
    try:
        data = parse(_read(path), str(path))
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
    return Config(path, theme, found.keys, tuple(problems))


def _read(path: Path) -> str:
    """Return the text of the settings; '' if the file does not exist."""
    try:
        return read_regular(path, LARGEST, follow=True).decode("utf-8-sig")
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise GaitsimError(f"cannot read {path}: {reason}") from None


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


def remember_theme(path: Path, theme: str) -> None:
    """Write a theme to the settings; keep the rest of the file, including comments."""
    import tomlkit

    from gaitsim.runs.files.atomic import write_bytes, writing

    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        text = _read(path)
    if not isinstance(parse(text, str(path)).get("tui", {}), dict):
        raise GaitsimError("'tui' must be a section, written as [tui]", where=str(path))
    document = tomlkit.parse(text)
    document.setdefault("tui", tomlkit.table())[THEME] = theme
    write_bytes(path, tomlkit.dumps(document).encode())


def format_problem(problem: GaitsimError) -> str:
    """Return a problem of the settings on one line, with its key and a remedy."""
    place = problem.key or problem.where
    what = problem.what if place in problem.what else f"{place}: {problem.what}"
    remedy = problem.remedy or (problem.allowed and f"allowed: {problem.allowed}")
    return f"• {what}; {remedy}" if remedy else f"• {what}"
