"""The user's settings: `config.toml` with a theme and keys. What is wrong is told, never fatal."""

import os
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError, nearest
from gaitsim.toml import literal, parse

SECTIONS = ("tui", "keys")
THEME = "theme"
MODIFIERS = {"ctrl", "shift", "alt", "meta", "super", "hyper"}


@dataclass(frozen=True)
class Config:
    """What a user chose.

    Attributes:
        path: the file.
        theme: the name of a theme; None where none is chosen.
        keys: keys by the id of what they do, as 'home.delete' = 'ctrl+d'.
        problems: what is wrong with the file.
    """

    path: Path
    theme: str | None = None
    keys: Mapping[str, str] = field(default_factory=dict)
    problems: tuple[GaitsimError, ...] = ()


def config_path() -> Path:
    """Where the settings are: in $XDG_CONFIG_HOME or ~/.config, whether there are any or not."""
    home = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    # By the specification, a relative path is to be ignored.
    folder = home if home.is_absolute() else Path.home() / ".config"
    return folder / "gaitsim" / "config.toml"


def read_config(path: Path) -> Config:
    """The settings in a file; those that can be read where some cannot."""
    try:
        data = parse(path.read_text(encoding="utf-8-sig"), str(path))
    except FileNotFoundError:
        return Config(path)
    except GaitsimError as error:
        return Config(path, problems=(error,))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not a text in UTF-8"
        return Config(path, problems=(GaitsimError(f"cannot read {path}: {reason}"),))
    found: list[GaitsimError] = list(_unknown(data, SECTIONS, "section", str(path)))
    tui, keys = (_section(data, name, path, found) for name in SECTIONS)
    found += _unknown(tui, (THEME,), "key", f"{path}, section tui")
    theme = tui.get(THEME)
    if theme is not None and not isinstance(theme, str):
        found.append(_wrong(path, f"tui.{THEME}", theme, "the name of a theme in quotes"))
        theme = None
    chosen = {}
    for name, key in _flat(keys).items():
        if isinstance(key, str) and key.strip():
            chosen[name] = key
        else:
            found.append(_wrong(path, f"keys.{name}", key, 'a key in quotes, as "ctrl+d"'))
    return Config(path, theme, chosen, tuple(found))


def check_theme(config: Config, themes: Collection[str]) -> GaitsimError | None:
    """What is wrong with the theme that is chosen, or None."""
    if config.theme is None or config.theme in themes:
        return None
    return GaitsimError(
        f"unknown theme {literal(config.theme)}",
        where=f"{config.path}, key tui.{THEME}",
        allowed=", ".join(sorted(themes)),
        remedy=nearest(config.theme, sorted(themes)),
    )


def check_keys(config: Config, ids: Collection[str], keys: Collection[str]) -> list[GaitsimError]:
    """What is wrong with the keys that are chosen.

    Args:
        config: the settings.
        ids: of all that keys can do.
        keys: names of keys that are longer than a character, without ctrl+ and the like.
    """
    found = []
    for name, chosen in config.keys.items():
        where = f"{config.path}, key keys.{name}"
        if name not in ids:
            remedy = nearest(name, sorted(ids)) or "the help of each screen (?) tells them"
            found.append(GaitsimError(f"unknown id {literal(name)}", where=where, remedy=remedy))
        for key in chosen.split(","):
            if not is_key(key.strip(), keys):
                bare = key.strip().rpartition("+")[2]
                found.append(
                    GaitsimError(
                        f"there is no key {literal(key.strip())}",
                        where=where,
                        allowed='a character, or a name such as "enter", "f5" and "ctrl+d"',
                        remedy=nearest(bare, sorted(keys)),
                    )
                )
    return found


def is_key(key: str, keys: Collection[str]) -> bool:
    """Whether there is a key of that name; `keys` as `check_keys` has them."""
    if len(key) == 1:
        return True
    *modifiers, bare = key.split("+")
    return {*modifiers} <= MODIFIERS and (len(bare) == 1 or bare in keys)


def remember_theme(path: Path, theme: str) -> None:
    """Write a theme to the settings; all else in the file stays, comments too.

    Raises:
        GaitsimError: the file is not TOML, or cannot be written.
    """
    import tomlkit

    from gaitsim.runs.files.atomic import write_bytes, writing

    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        text = path.read_text(encoding="utf-8-sig") if path.exists() else ""
    parse(text, str(path))
    document = tomlkit.parse(text)
    section = document.setdefault("tui", tomlkit.table())
    section[THEME] = theme
    write_bytes(path, tomlkit.dumps(document).encode())


def _section(
    data: Mapping[str, Any], name: str, path: Path, found: list[GaitsimError]
) -> Mapping[str, Any]:
    section = data.get(name, {})
    if isinstance(section, dict):
        return section
    found.append(_wrong(path, name, section, f"a section [{name}]"))
    return {}


def _flat(table: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """The values by dotted key: `home.delete = …` is a table in a table to TOML."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        flat |= (
            _flat(value, f"{before}{key}.") if isinstance(value, dict) else {before + key: value}
        )
    return flat


def _unknown(
    table: Mapping[str, Any], known: Iterable[str], noun: str, where: str
) -> list[GaitsimError]:
    names = list(known)
    return [
        GaitsimError(
            f"unknown {noun} {literal(key)}",
            where=where,
            allowed=", ".join(names),
            remedy=nearest(key, names),
        )
        for key in table
        if key not in names
    ]


def _wrong(path: Path, key: str, value: Any, right: str) -> GaitsimError:
    return GaitsimError(
        f"{literal(value)} is not allowed", where=f"{path}, key {key}", remedy=f"give {right}"
    )
