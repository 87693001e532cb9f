"""Create the package of a new plugin from templates, either completely or not at all.

The templates use `string.Template`, with placeholders such as `$plugin` and `$module`.
"""

import os
import re
from collections.abc import Iterator
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from string import Template

from gaitsim.plugin import EXPERIMENTS, PLUGINS, Entry, GaitsimError, entries, unknown
from gaitsim.plugin.runs import draft_folder, sweep

PREFIX = "gaitsim-"
LONGEST = 40
_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_SUFFIX = {"organism": "Body"}  # ends the class's name; other kinds use the kind itself


def new_package(name: str, kind: str, parent: Path) -> Path:
    """Write a complete, working package of a new plugin to the folder `name`.

    Args:
        name: name of the plugin; a prefix 'gaitsim-' applies only to the folder.
        kind: one of `PLUGINS`, such as 'organism'.
        parent: folder in which the new folder is created.

    Returns:
        The path of the new folder.
    """
    if kind not in PLUGINS:
        raise unknown("kind of plugin", kind, PLUGINS)
    plugin = name.removeprefix(PREFIX)
    _check_name(plugin, name)
    _check_free(plugin, kind)
    folder = parent / name
    if os.path.lexists(folder):
        raise GaitsimError(
            f"{folder} already exists", remedy="choose another name, or move that folder"
        )
    _write(folder, _texts(plugin, kind))
    return folder


def _check_name(plugin: str, name: str) -> None:
    if _NAME.fullmatch(plugin) and len(plugin) <= LONGEST:
        return
    better = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-0123456789")[:LONGEST].rstrip("-")
    raise GaitsimError(
        f"invalid name for a plugin and its package: {name!r}",
        allowed=f"up to {LONGEST} lowercase letters, digits and single hyphens, a letter first",
        remedy=f"{better!r}" if _NAME.fullmatch(better) else "a name such as 'two-legs'",
    )


def _check_free(plugin: str, kind: str) -> None:
    names = [plugin, f"{plugin}-distance"] if kind == "organism" else [plugin]
    taken = [
        claim
        for other in (*PLUGINS, EXPERIMENTS)
        for name in names
        for claim in entries(other).get(name, [])
    ]
    if taken:
        raise GaitsimError(
            f"the name {taken[0].name!r} is taken: {_whose(taken[0])}",
            remedy="choose another name: two plugins with the same name cannot be used",
        )
    module = f"gaitsim_{plugin.replace('-', '_')}"
    if find_spec(module) is not None:
        raise GaitsimError(f"a package {module} is already installed", remedy="choose another name")


def _whose(entry: Entry) -> str:
    kind = "preset" if entry.kind == EXPERIMENTS else entry.kind
    return f"{kind} of package {entry.source}"


def _texts(plugin: str, kind: str) -> Iterator[tuple[str, str]]:
    """Yield the path and text of each file of the package."""
    module = f"gaitsim_{plugin.replace('-', '_')}"
    values = {
        "plugin": plugin,
        "project": f"{PREFIX}{plugin}",
        "module": module,
        "kind": kind,
        "title": plugin.replace("-", " ").capitalize(),
        "class_name": "".join(part.capitalize() for part in plugin.split("-"))
        + _SUFFIX.get(kind, kind.capitalize()),
    }
    values["entries"] = _filled("entries", kind, values)
    values["use"] = _filled("use", kind, values)
    yield "pyproject.toml", _filled("pyproject.toml", "", values)
    yield "README.md", _filled("README.md", "", values)
    yield f"src/{module}/__init__.py", _filled("plugin.py", kind, values)
    yield f"src/{module}/py.typed", ""
    yield f"tests/test_{module}.py", _filled("test.py", kind, values)
    if kind == "organism":
        yield f"src/{module}/{plugin}.toml", _filled("preset.toml", "", values)


def _filled(file: str, kind: str, values: dict[str, str]) -> str:
    folder = files("gaitsim_testing") / "templates"
    text = (folder / kind / f"{file}.txt" if kind else folder / f"{file}.txt").read_text("utf-8")
    return Template(text).substitute(values)


def _write(folder: Path, texts: Iterator[tuple[str, str]]) -> None:
    sweep(folder.parent)
    try:
        with draft_folder(folder.parent) as draft:
            for name, text in texts:
                path = draft / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            draft.rename(folder)
    except OSError as error:
        raise GaitsimError(
            f"cannot write {folder}: {error.strerror}",
            remedy="change to a writable folder",
        ) from None
