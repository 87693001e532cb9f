"""`gaitsim plugins list`."""

from gaitsim.console.printing import notice, print_table
from gaitsim.registry import KINDS, PRODUCTS, entries, unreadable


def list_() -> None:
    """List all plugins by kind, with their packages, without importing them.

    [bold]Example[/bold]

    gaitsim plugins list
    """
    rows = []
    for kind in (*KINDS, *PRODUCTS):
        for name, claims in entries(kind).items():
            packages = " and ".join(claim.source for claim in claims)
            conflict = "  (conflict: cannot be used)" if len(claims) > 1 else ""
            rows.append([kind, name, packages + conflict])
    print_table(["kind", "name", "package"], rows)
    for folder in unreadable():
        notice(f"Warning: the entry points of {folder} cannot be read; reinstall its package.")
