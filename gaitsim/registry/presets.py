"""Presets and studies: TOML files that packages ship.

An entry point of the group `gaitsim.experiments` or `gaitsim.studies` has the file's name,
its value is the package that contains `<name>.toml`.
"""

import sys
from importlib.machinery import ModuleSpec
from importlib.resources import files
from pathlib import Path

from gaitsim.registry import EXPERIMENTS, Entry, contract_error, find, plugin_errors


def read_preset(name: str, kind: str = EXPERIMENTS) -> str:
    """Return the TOML text of a preset; import its package only if it is in an archive.

    Raises:
        PluginError: no package, or more than one, has a preset of that name, or its package
            fails or does not contain the file.
    """
    entry = find(kind, name)
    with plugin_errors(entry, "being read"):
        text = _read(entry, f"{name}.toml")
    if text is None:
        raise contract_error(entry, f"has no file {name}.toml")
    return text


def _read(entry: Entry, file: str) -> str | None:
    for folder in _folders(entry.target):
        if (folder / file).is_file():
            return (folder / file).read_text(encoding="utf-8-sig")
    resource = files(entry.target) / file
    return resource.read_text(encoding="utf-8-sig") if resource.is_file() else None


def _folders(package: str) -> list[Path]:
    """Find the folders of a package as an import would, but without importing it."""
    path: list[str] | None = None
    parts = package.split(".")
    for count in range(1, len(parts) + 1):
        spec = _spec(".".join(parts[:count]), path)
        if spec is None or spec.submodule_search_locations is None:
            return []
        path = list(spec.submodule_search_locations)
    return [Path(folder) for folder in path or []]


def _spec(name: str, path: list[str] | None) -> ModuleSpec | None:
    for finder in sys.meta_path:
        find_spec = getattr(finder, "find_spec", None)
        spec: ModuleSpec | None = find_spec(name, path) if find_spec else None
        if spec is not None:
            return spec
    return None
