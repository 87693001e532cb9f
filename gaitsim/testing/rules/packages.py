"""What there is to check: installed plugins, an installed package's, or those of a folder."""

import os
import re
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from gaitsim import registry
from gaitsim.errors import GaitsimError, PluginError, nearest
from gaitsim.registry import EXPERIMENTS, KINDS, STUDIES, Entry
from gaitsim.testing.report import Finding, error

CHECKED = (*KINDS, EXPERIMENTS)
_GROUP = "gaitsim."


@dataclass(frozen=True)
class Chosen:
    """Plugins and presets to check.

    Attributes:
        entries: which ones.
        path: folders to import them from, before what is installed.
    """

    entries: tuple[Entry, ...]
    path: tuple[str, ...] = ()


def installed() -> tuple[Entry, ...]:
    """All plugins and presets that are installed, whatever state they are in."""
    return tuple(
        entry for kind in CHECKED for claims in registry.entries(kind).values() for entry in claims
    )


@contextmanager
def chosen(reference: str | Path | None) -> Iterator[Chosen]:
    """What a name, a package's name or a package's folder stands for; None is all installed.

    A folder need not be installed: its entry points are read from its pyproject.toml, and
    while the block lasts a folder with metadata stands in for the installation.

    Raises:
        PluginError: nothing has that name.
        GaitsimError: the folder holds no package with entry points of gaitsim's.
    """
    everything = installed()
    if reference is None:
        yield Chosen(everything)
        return
    named = tuple(e for e in everything if e.name == str(reference))
    packaged = tuple(e for e in everything if _normal(e.package) == _normal(str(reference)))
    folder = Path(reference)
    is_path = isinstance(reference, Path) or folder.name != reference or reference in (".", "..")
    if not is_path and (named or packaged):
        yield Chosen(named or packaged)
    # os.path, unlike pathlib, answers for names that no file can have, too.
    elif is_path or os.path.isfile(folder / "pyproject.toml"):  # noqa: PTH113
        with TemporaryDirectory(prefix="gaitsim-") as metadata:
            yield _of_folder(folder.resolve(), Path(metadata))
    else:
        known = sorted({e.name for e in everything} | {e.package for e in everything})
        raise PluginError(
            f"no plugin, package or folder is called {str(reference)!r}",
            allowed=", ".join(known),
            remedy=nearest(str(reference), known) or "a folder is one that has a pyproject.toml",
        )


def _normal(package: str) -> str:
    return re.sub(r"[-_.]+", "-", package).lower()


def _of_folder(folder: Path, metadata: Path) -> Chosen:
    file = folder / "pyproject.toml"
    project = _project(file)
    name, version = str(project.get("name", folder.name)), str(project.get("version", "0"))
    points = {
        group.removeprefix(_GROUP): names
        for group, names in _table(project, "entry-points", file).items()
        if group.startswith(_GROUP)
    }
    strange = sorted({*points} - {*CHECKED, STUDIES})
    if strange or not any(points.values()):
        raise GaitsimError(
            f"there is no kind of plugin {', '.join(strange)}"
            if strange
            else f"the package {name} registers no plugin",
            where=f"{file}, project.entry-points",
            allowed=", ".join(f'[project.entry-points."{_GROUP}{kind}"]' for kind in CHECKED),
            remedy=nearest(strange[0], CHECKED) if strange else "see docs/plugins.md",
        )
    found = tuple(
        Entry(kind, str(key), str(target), name, version)
        for kind in CHECKED
        for key, target in points.get(kind, {}).items()
    )
    _install(metadata, name, version, points)
    return Chosen(found, (str(metadata), *_sources(folder, found)))


def _project(file: Path) -> dict[str, Any]:
    try:
        data = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as problem:
        raise GaitsimError(
            f"cannot read {file}: {problem.strerror}",
            remedy="name the folder of a package, in which its pyproject.toml is",
        ) from None
    except ValueError as problem:
        raise GaitsimError(f"{file} is no TOML: {problem}", remedy="correct it") from None
    return _table(data, "project", file)


def _table(data: dict[str, Any], key: str, file: Path) -> dict[str, Any]:
    table = data.get(key, {})
    if not isinstance(table, dict) or (
        key == "entry-points" and not all(isinstance(names, dict) for names in table.values())
    ):
        raise GaitsimError(f"{key} is not a table", where=str(file), remedy="correct it")
    return table


def _sources(folder: Path, entries: Sequence[Entry]) -> Iterator[str]:
    """The folders in which the modules are: `src`, or the package's own."""
    modules = {entry.target.partition(":")[0].partition(".")[0].strip() for entry in entries}
    for source in (folder / "src", folder):
        if any(
            (source / module).is_dir() or (source / f"{module}.py").is_file() for module in modules
        ):
            yield str(source)


def _install(metadata: Path, name: str, version: str, points: dict[str, Any]) -> None:
    """Write what an installation would: name, version and entry points."""
    full = re.sub(r"[^A-Za-z0-9.+-]+", "_", f"{name.replace('-', '_')}-{version}")
    info = metadata / f"{full}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", encoding="utf-8"
    )
    lines = [
        line
        for kind, names in points.items()
        for line in (f"[{_GROUP}{kind}]", *(f"{key} = {value}" for key, value in names.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def rivals(entry: Entry) -> Finding | None:
    """What is wrong where another package registers the same name; None where none does."""
    others = [
        claim.source
        for claim in registry.entries(entry.kind).get(entry.name, [])
        if (_normal(claim.package), claim.target) != (_normal(entry.package), entry.target)
        # An older version of the same package is replaced when this one is installed.
        and (_normal(claim.package) != _normal(entry.package) or claim.version == entry.version)
    ]
    if not others:
        return None
    return error(
        "name",
        f"a name of its own: what several packages call {entry.name!r} cannot be used at all",
        f"registered by {' and '.join(others)}, too",
        "choose another name in the entry points",
    )
