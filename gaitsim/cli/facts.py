"""Print facts about a body: names and values under headings."""

from rich.table import Table

from gaitsim.cli.console import output
from gaitsim.contracts import Facts
from gaitsim.render.terminal.text import visible


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
