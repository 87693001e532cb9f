"""`gaitsim plugins list`."""

from gaitsim.cli.console import notice, output, table
from gaitsim.registry import KINDS, entries, unreadable


def list_() -> None:
    """List all plugins by kind, with the package of each. Imports none of them.

    [bold]Example[/bold]

    gaitsim plugins list
    """
    made = table("kind", "name", "package")
    for kind in KINDS:
        for name, claims in entries(kind).items():
            packages = " and ".join(claim.source for claim in claims)
            conflict = "  (conflict: cannot be used)" if len(claims) > 1 else ""
            made.add_row(kind, name, packages + conflict)
    output().print(made, markup=False)
    for folder in unreadable():
        notice(f"Warning: the entry points of {folder} cannot be read; reinstall its package.")
