"""`gaitsim experiments list`."""

from gaitsim.console.printing import print_table
from gaitsim.errors import GaitsimError
from gaitsim.registry import EXPERIMENTS, entries
from gaitsim.registry.loading import read_preset
from gaitsim.toml import parse


def list_() -> None:
    """List the presets of all installed packages."""
    rows = [
        (name, _describe(name), " and ".join(claim.package for claim in claims))
        for name, claims in entries(EXPERIMENTS).items()
    ]
    print_table(["name", "description", "package"], rows)


def _describe(name: str) -> str:
    try:  # not by an outline: that would import NumPy and pydantic, and slow down the list
        return str(parse(read_preset(name), f"preset {name}").get("description", ""))
    except GaitsimError as error:
        return f"broken: {error.what}"
