"""Print facts about a body: names and values under headings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.table import Table

from gaitsim.console.printing import output
from gaitsim.render.terminal.text import visible

if TYPE_CHECKING:
    from gaitsim.contracts import Facts


def print_facts(facts: Facts) -> None:
    """Print each heading and its lines; long values wrap within their column."""
    console = output()
    for at, (heading, lines) in enumerate(facts.items()):
        if at:
            console.print()
        console.print(heading, style="bold")
        table = Table(box=None, pad_edge=False, show_header=False, padding=(0, 2, 0, 0))
        for name, value in lines.items():
            table.add_row(f"  {visible(name)}", *([visible(value)] if value else []))
        console.print(table)
