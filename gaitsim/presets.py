"""Ready experiments: TOML files that packages ship.

An entry point of the group `gaitsim.experiments` has the experiment's name, and for value
the package of which `<name>.toml` is a resource.
"""

from importlib.resources import files

from gaitsim.errors import PluginError
from gaitsim.registry import EXPERIMENTS, containing, find


def read_preset(name: str) -> str:
    """The TOML text of a preset.

    Raises:
        PluginError: no package, or more than one, has an experiment of that name, or its
            package fails or does not contain the file.
    """
    entry = find(EXPERIMENTS, name)
    with containing(entry, "being read"):
        resource = files(entry.target) / f"{name}.toml"
        if resource.is_file():
            return resource.read_text(encoding="utf-8")
    raise PluginError(
        f"{entry} has no file {name}.toml",
        where=entry.target,
        remedy=f"update {entry.package}, or report it to its author",
    )
