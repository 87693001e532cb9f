"""`gaitsim members`."""

import csv
import io
from pathlib import Path
from typing import Annotated, Any

import typer

from gaitsim.cli.console import echo, output, print_json, print_table, wrote
from gaitsim.cli.options import Json, RunName
from gaitsim.contracts.search import Members
from gaitsim.errors import GaitsimError, RunError
from gaitsim.gait.files.writer import check_folder
from gaitsim.individual import Member
from gaitsim.render.terminal.text import number
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import command, find_run
from gaitsim.runs.snapshot import RunSnapshot


def members(
    run: RunName,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Write a CSV file instead of a table.")
    ] = None,
    json: Json = False,
) -> None:
    """List the front or the archive that a search keeps.

    Members have numbers from 1: those of a front by its first objective, those of an archive by
    its cells. A number names a member in other commands, as --member 3, or RUN#3 after --from.

    [bold]Examples[/bold]

    gaitsim members spider-front

    gaitsim members spider-front --out front.csv

    gaitsim play spider-front --member 3

    gaitsim run spider --from spider-front#3
    """
    if out is not None:
        if out.suffix.lower() != ".csv":
            raise GaitsimError(f"{out} is not a CSV file", where="--out", allowed="FILE.csv")
        check_folder(out)
    opened = RunSnapshot(find_run(run))
    found = _members(opened)
    columns, rows = _table(found)
    if out is not None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([columns, *rows])
        write_bytes(out, text.getvalue().encode())
        wrote(out)
        echo(f"{out}: {len(rows)} members")
    elif json:
        for row in rows:
            print_json(dict(zip(columns, row, strict=True)))
    else:
        _print(opened, found, columns, rows)


def _members(run: RunSnapshot) -> Members:
    found = run.members
    if found is None:
        name = run.experiment.entries["search"].name
        raise RunError(
            f"the search {name!r} of the run {run.path} keeps neither a front nor an archive",
            remedy="evolve with one that does, such as nsga-2 or map-elites",
        )
    return found


def _table(members: Members) -> tuple[list[str], list[list[Any]]]:
    """Return the columns and a row for each member: number, score, values and cells."""
    values = {"score": members.scores, **members.values}
    columns = {"member": range(1, len(members.scores) + 1)}
    columns |= {name: found.tolist() for name, found in values.items()}
    if members.cells is not None:
        cells = members.cells.T.tolist()
        names = ["cell"] if len(cells) == 1 else [f"cell {name}" for name in members.values]
        columns |= dict(zip(names, cells, strict=True))
    return [*columns], [[*row] for row in zip(*columns.values(), strict=True)]


def _print(run: RunSnapshot, members: Members, columns: list[str], rows: list[list[Any]]) -> None:
    console = output()
    count = len(rows)
    what = run.experiment.search.keeps
    console.print(
        f"{run.path}: {what} of generation {run.generation}, {count} member{'s' * (count != 1)}",
        style="bold",
    )
    if not count:
        console.print("Every individual failed.")
        return
    first = run.individual(Member(1))
    units = {name: first.unit_of(name) for name in ("score", *members.values)}
    heads = [f"{name}, {units[name]}" if units.get(name) else name for name in columns]
    cells = [[number(one) if isinstance(one, float) else str(one) for one in row] for row in rows]
    print_table(heads, cells, numbers=heads)
    console.print(f"Watch one: {command('play', run.path, '--member', 1)}", style="dim")
