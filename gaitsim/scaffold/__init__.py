"""Create the package of a new plugin from templates, complete or not at all.

Templates are those of `string.Template`, with names such as `$plugin` and `$module`.
"""

import os
import re
from collections.abc import Iterator
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from string import Template

from gaitsim.errors import GaitsimError, unknown
from gaitsim.registry import EXPERIMENTS, KINDS, Entry, entries
from gaitsim.runs.files.drafts import draft_folder, sweep

PREFIX = "gaitsim-"
LONGEST = 40
_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_SUFFIX = {"organism": "Body"}  # of a class's name; the kind's own name for the other kinds


def new_package(name: str, kind: str, parent: Path) -> Path:
    """Write the package of a new plugin into the folder `name`; it works as it is.

    Args:
        name: of the plugin; a prefix 'gaitsim-' belongs to the folder alone.
        kind: 'organism', 'fitness', 'search', 'selection', 'crossover' or 'mutation'.
        parent: of the new folder.

    Returns:
        The folder.

    Raises:
        GaitsimError: the name is invalid or taken, the kind is unknown, or the folder exists or
            cannot be created; nothing is written then.
    """
    if kind not in KINDS:
        raise unknown("kind of plugin", kind, KINDS)
    plugin = name.removeprefix(PREFIX)
    _check_name(plugin, name)
    _check_free(plugin, kind)
    folder = parent / name
    if os.path.lexists(folder):
        raise GaitsimError(
            f"{folder} exists already", remedy="choose another name, or move it away"
        )
    _write(folder, _texts(plugin, kind))
    return folder


def _check_name(plugin: str, name: str) -> None:
    if _NAME.fullmatch(plugin) and len(plugin) <= LONGEST:
        return
    better = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-0123456789")[:LONGEST].rstrip("-")
    raise GaitsimError(
        f"{name!r} cannot name a plugin and its package",
        allowed=f"up to {LONGEST} small letters, digits and single hyphens, a letter first",
        remedy=f"{better!r}" if _NAME.fullmatch(better) else "a name such as 'two-legs'",
    )


def _check_free(plugin: str, kind: str) -> None:
    names = [plugin, f"{plugin}-distance"] if kind == "organism" else [plugin]
    taken = [
        claim
        for other in (*KINDS, EXPERIMENTS)
        for name in names
        for claim in entries(other).get(name, [])
    ]
    if taken:
        raise GaitsimError(
            f"the name {taken[0].name!r} is taken: {_whose(taken[0])}",
            remedy="choose another name: of two plugins with one name neither can be used",
        )
    module = f"gaitsim_{plugin.replace('-', '_')}"
    if find_spec(module) is not None:
        raise GaitsimError(f"a package {module} is installed already", remedy="choose another name")


def _whose(entry: Entry) -> str:
    kind = "preset" if entry.kind == EXPERIMENTS else entry.kind
    return f"{kind} of package {entry.source}"


def _texts(plugin: str, kind: str) -> Iterator[tuple[str, str]]:
    """Yield path and text of each file of the package."""
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
    folder = files("gaitsim.scaffold") / "templates"
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
            remedy="go to a folder in which you may write",
        ) from None
