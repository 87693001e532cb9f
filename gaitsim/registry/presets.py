"""Presets and studies: TOML files in packages.

The name of an entry point of the group `gaitsim.experiments` or `gaitsim.studies` is the file's
name; its value is the package that contains `<name>.toml`.
"""

from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from gaitsim.registry import EXPERIMENTS, Entry, contract_error, find, plugin_errors


def read_preset(name: str, kind: str = EXPERIMENTS) -> str:
    """Return the TOML text of a preset or study.

    The package is imported only if it is in an archive.

    Args:
        name: name of the preset or study.
        kind: `EXPERIMENTS` or `STUDIES`.
    """
    entry = find(kind, name)
    with plugin_errors(entry, "being read"):
        text = _read(entry, f"{name}.toml")
    if text is None:
        raise contract_error(entry, f"has no file {name}.toml")
    return text


def _read(entry: Entry, file: str) -> str | None:
    # Only locate the package's folders: an import would run its code.
    top, *inner = entry.target.split(".")
    spec = find_spec(top)
    for folder in (spec and spec.submodule_search_locations) or ():
        path = Path(folder, *inner, file)
        if path.is_file():
            return path.read_text(encoding="utf-8-sig")
    resource = files(entry.target) / file
    return resource.read_text(encoding="utf-8-sig") if resource.is_file() else None
