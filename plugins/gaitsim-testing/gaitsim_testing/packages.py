"""Select the plugins to check: all installed plugins, or the plugins of a package or folder."""

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from gaitsim.plugin import (
    COMMANDS,
    EXPERIMENTS,
    FILES,
    KINDS,
    OPERATORS,
    PLUGINS,
    PRODUCTS,
    REFLEX,
    STUDIES,
    Entry,
    GaitsimError,
    PluginError,
    nearest,
    normalized,
    registry,
    toml,
)
from gaitsim.plugin.runs import read_file

CHECKED = (*PLUGINS, EXPERIMENTS, COMMANDS)
"""The kinds of plugin that can be checked."""
MODULES = {
    "names": CHECKED,
    "declarations": PLUGINS,
    "bodies": ("organism",),
    "fitnesses": ("fitness",),
    "searches": ("search",),
    "operators": OPERATORS,
    "reflexes": (REFLEX,),
    "products": PRODUCTS,
    "presets": (EXPERIMENTS,),
    "commands": (COMMANDS,),
    "processes": (*KINDS, REFLEX),
}
"""The kinds of plugin that each module of `gaitsim_testing.checks` checks, in this order."""
_GROUP = "gaitsim."


@dataclass(frozen=True)
class PluginSelection:
    """Plugins and presets to check.

    Attributes:
        entries: entries of the plugins and presets.
        path: folders to import them from, before installed packages.
    """

    entries: tuple[Entry, ...]
    path: tuple[str, ...] = ()


@contextmanager
def select_plugins(reference: str | Path | None) -> Iterator[PluginSelection]:
    """Select plugins by the name of a plugin or package, or by the folder of a package.

    The package in a folder need not be installed: its entry points are read from its
    pyproject.toml. Within the `with` block, a temporary folder contains the metadata of an
    installation.

    Args:
        reference: name, such as `spider` or `organism:spider`, or folder; None for all installed
            plugins.
    """
    everything = tuple(
        entry for kind in CHECKED for claims in registry.entries(kind).values() for entry in claims
    )
    if reference is None:
        yield PluginSelection(everything)
        return
    named = tuple(e for e in everything if str(reference) in (e.name, f"{e.kind}:{e.name}"))
    packaged = tuple(e for e in everything if normalized(e.package) == normalized(str(reference)))
    folder = Path(reference)
    is_path = isinstance(reference, Path) or folder.name != reference or reference in (".", "..")
    if not is_path and (named or packaged):
        yield PluginSelection(named or packaged)
    # Unlike pathlib, os.path does not raise an error for an invalid file name.
    elif is_path or os.path.isfile(folder / "pyproject.toml"):  # noqa: PTH113
        with TemporaryDirectory(prefix="gaitsim-") as metadata:
            yield _plugins_of_folder(folder.resolve(), Path(metadata))
    else:
        known = sorted({e.name for e in everything} | {e.package for e in everything})
        raise PluginError(
            f"there is no plugin, package or folder {str(reference)!r}",
            allowed=", ".join(known),
            remedy=nearest(str(reference), known)
            or "for a package, give the folder that contains its pyproject.toml",
        )


def _plugins_of_folder(folder: Path, metadata: Path) -> PluginSelection:
    file = folder / "pyproject.toml"
    remedy = "give the folder of a package, which contains its pyproject.toml"
    text = read_file(file, "project", "'gaitsim plugins new'", remedy)
    project = _table(toml.parse(text, str(file)), "project", file)
    name, version = str(project.get("name", folder.name)), str(project.get("version", "0"))
    points = {
        group.removeprefix(_GROUP): names
        for group, names in _table(project, "entry-points", file).items()
        if group.startswith(_GROUP)
    }
    unknown = sorted({*points} - {*CHECKED, STUDIES, FILES})
    if unknown or not any(points.values()):
        raise GaitsimError(
            f"unknown kind of plugin {', '.join(unknown)}"
            if unknown
            else f"the package {name} does not register any plugins",
            where=f"{file}, project.entry-points",
            allowed=", ".join(f'[project.entry-points."{_GROUP}{kind}"]' for kind in CHECKED),
            remedy=nearest(unknown[0], CHECKED) if unknown else "see docs/plugins.md",
        )
    found = tuple(
        Entry(kind, str(key), str(target), name, version)
        for kind in CHECKED
        for key, target in points.get(kind, {}).items()
    )
    _write_metadata(metadata, name, version, points)
    return PluginSelection(found, (str(metadata), *_source_folders(folder, found)))


def _table(data: dict[str, Any], key: str, file: Path) -> dict[str, Any]:
    table = data.get(key, {})
    if not isinstance(table, dict) or (
        key == "entry-points" and not all(isinstance(names, dict) for names in table.values())
    ):
        raise GaitsimError(f"{key} is not a table", where=str(file), remedy="correct the file")
    return table


def _source_folders(folder: Path, entries: Sequence[Entry]) -> Iterator[str]:
    """Yield the folders that contain the modules: `src`, the folder of the package, or both."""
    modules = {entry.target.partition(":")[0].partition(".")[0].strip() for entry in entries}
    for source in (folder / "src", folder):
        if any(
            (source / module).is_dir() or (source / f"{module}.py").is_file() for module in modules
        ):
            yield str(source)


def _write_metadata(metadata: Path, name: str, version: str, points: dict[str, Any]) -> None:
    """Write the metadata of an installation: name, version and entry points."""
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


def other_claims(entry: Entry) -> list[str]:
    """Return the other packages that register the same name, with their versions."""
    return [
        claim.source
        for claim in registry.entries(entry.kind).get(entry.name, [])
        if (normalized(claim.package), claim.target) != (normalized(entry.package), entry.target)
        # Installing this version replaces an older version of the same package.
        and (
            normalized(claim.package) != normalized(entry.package) or claim.version == entry.version
        )
    ]
