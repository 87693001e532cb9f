"""`gaitsim members`."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gaitsim.actions.action import WORKERS, OneRun
from gaitsim.console.printing import echo, output, print_json, print_table, report_files
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Pair
from gaitsim.errors import GaitsimError, unknown
from gaitsim.render.terminal.text import number
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import command

if TYPE_CHECKING:
    from gaitsim.contracts import Members
    from gaitsim.storage.snapshot import RunSnapshot


FREQUENCY = "stride frequency"

WIDEST, HIGHEST = 80, 36  # characters, at most, in a terminal
PIPED = 80, 30  # characters, if the output is not a terminal


class ListMembers(OneRun):
    """List the members of a run's front or archive.

    The search nsga-2 keeps a front: the individuals that no other individual beats in every
    objective. The search map-elites keeps an archive: the best individual of each cell in a space
    of measures.

    Members are numbered from 1: those of a front in the order of the first objective, those of an
    archive in the order of their cells. Other commands accept these numbers, as in --member 3 or
    --from RUN#3.

    [bold]Examples[/bold]

    gaitsim members spider-front

    gaitsim members spider-front --out front.csv

    gaitsim members spider-atlas --gaits --out atlas.csv

    gaitsim members spider-front --map

    gaitsim members spider-atlas --map --axes 'duty factor L1' 'duty factor R1'

    gaitsim play spider-front --member 3

    gaitsim run spider --from spider-front#3
    """

    out: Path | None = option(
        None, "write a CSV file instead of printing a table", placeholder="FILE.csv"
    )
    gaits: bool = option(
        False, "add columns with the name, duty factor and stride frequency of each gait"
    )
    workers: int | None = WORKERS
    show_map: bool = option(
        False,
        "print a map of the archive, or a scatter plot of the front, along two axes instead of a "
        "table",
        flag="--map",
    )
    axes: Pair | None = option(
        None,
        "axes of the map",
        unset="the first two axes of the archive or objectives of the front",
        placeholder="NAME NAME",
    )

    def do(self) -> None:
        """Print or write the table, or print the map."""
        from gaitsim.storage.snapshot import RunSnapshot

        self._check()
        run = RunSnapshot.find(self.run)
        found = run.required_members("evolve with a search such as 'nsga-2' or 'map-elites'")
        if self.show_map:
            _print_map(run, found, self.axes)
            return
        columns, rows = _table(found, _gaits(run, found, self.workers) if self.gaits else {})
        if self.out is not None:
            text = io.StringIO()
            csv.writer(text, lineterminator="\n").writerows([columns, *rows])
            write_bytes(self.out, text.getvalue().encode())
            report_files(self.out)
            echo(f"{self.out}: {len(rows)} member{'s' * (len(rows) != 1)}")
        elif self.json_lines:
            for row in rows:
                print_json(dict(zip(columns, row, strict=True)))
        else:
            _print(run, found, columns, rows)

    def _check(self) -> None:
        """Check that the options do not contradict each other, and that the file can be written."""
        from gaitsim.gait.gait_files import check_folder

        if self.axes is not None and not self.show_map:
            raise GaitsimError("--axes needs --map", where="--axes", remedy="add --map")
        if self.show_map and (self.json_lines or self.gaits or self.out is not None):
            raise GaitsimError(
                "--map cannot be combined with --json, --gaits or --out",
                where="--map",
                allowed="--axes",
            )
        if self.out is not None:
            if self.out.suffix.lower() != ".csv":
                raise GaitsimError(
                    f"{self.out} does not have the extension .csv",
                    where="--out",
                    allowed="FILE.csv",
                )
            check_folder(self.out)


def _gaits(run: RunSnapshot, members: Members, workers: int | None) -> dict[str, list[Any]]:
    """Return the gaits of the members as columns of the table.

    The frequency of a gait without strides is None.
    """
    from gaitsim.console.progress_bar import Progress
    from gaitsim.gait.repertoire import RepertoireGait, gaits_of

    found: list[RepertoireGait] = []
    experiment = run.experiment_at(run.generation)
    with Progress("naming gaits", "members", len(members.scores)) as progress:
        for part in gaits_of(experiment, members.genomes, workers):
            found += part
            progress.advance(len(part))
    return {
        "gait": [one.name.name for one in found],
        "duty factor": [one.duty_factor for one in found],
        FREQUENCY: [one.frequency for one in found],
    }


def _table(members: Members, more: Mapping[str, list[Any]]) -> tuple[list[str], list[list[Any]]]:
    """Return the names of the columns and one row per member.

    The columns are number, score, values, those in `more`, and cells.
    """
    values = {"score": members.scores, **members.values}
    columns: dict[str, Any] = {"member": range(1, len(members.scores) + 1)}
    columns |= {name: found.tolist() for name, found in values.items()}
    columns |= {name: found for name, found in more.items() if name not in columns}
    if members.cells is not None:
        cells = members.cells.T.tolist()
        names = ["cell"] if len(cells) == 1 else [f"cell {name}" for name in members.values]
        columns |= dict(zip(names, cells, strict=True))
    return [*columns], [[*row] for row in zip(*columns.values(), strict=True)]


def _print(run: RunSnapshot, members: Members, columns: list[str], rows: list[list[Any]]) -> None:
    from gaitsim.individual import Member

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
    units = {name: first.unit_of(name) for name in ("score", *members.values)} | {FREQUENCY: "Hz"}
    heads = [f"{name}, {units[name]}" if units.get(name) else name for name in columns]
    cells = [[_format(one) for one in row] for row in rows]
    print_table(heads, cells, numbers=[head for head in heads if head != "gait"])
    console.print(f"Watch one: {command('play', run.path, '--member', 1)}", style="dim")


def _format(value: Any) -> str:
    if value is None:
        return "–"
    return number(value) if isinstance(value, float) else str(value)


def _print_map(run: RunSnapshot, members: Members, axes: tuple[str, ...] | None) -> None:
    """Print members along two axes (None: the first pair), with the best one marked.

    An archive is printed as a map, a front as a scatter plot.
    """
    from gaitsim.console.characters import lines
    from gaitsim.console.streams import results
    from gaitsim.individual import Member
    from gaitsim.render.archive_view import ArchiveView
    from gaitsim.render.front_view import FrontView
    from gaitsim.render.terminal import heat_map, scatter
    from gaitsim.render.terminal.member_picture import MemberPicture, axis_labels, styles, units_of

    view = ArchiveView.of(members) or FrontView.of(run)
    assert view is not None, "members are those of an archive or a front"
    for name in axes or ():
        if name not in view.names:
            raise unknown("axis", name, view.names, where="--axes")
    if axes is not None and axes[0] == axes[1]:
        raise GaitsimError("the two axes of a map must differ", where="--axes")
    names = axes or next(iter(view.pairs), view.names)
    console = output()
    is_map = isinstance(view, ArchiveView)
    text = (heat_map if is_map else scatter).summary(run, view)
    console.print(f"{run.path}: {text}", style="bold")
    if not len(members.scores):
        console.print("Every individual failed.")
        return
    terminal = results().isatty()
    width = min(console.width, WIDEST) if terminal else PIPED[0]
    height = min(console.height - 4, HIGHEST) if terminal else PIPED[1]
    shaded = console.no_color or console.color_system is None
    words = axis_labels(view.names, units_of(run.individual(Member(1)), view.names))
    drawn: MemberPicture
    if isinstance(view, ArchiveView):
        drawn = heat_map.HeatMap(view, names, words, width, height, shaded=shaded)
    else:
        third = next((name for name in view.names if name not in names), "")
        drawn = scatter.Scatter(view, names, words, width, height, colour=third, shaded=shaded)
    if not drawn.fits:
        raise GaitsimError("the terminal is too small for a map", remedy="enlarge it")
    best = view.best
    assert best is not None, "a front or an archive with members has a best one"
    for line in lines(*drawn.draw(drawn.place_of(best)), styles("default", "bright_black")):
        line.rstrip()
        if line.plain:
            console.print(line)
    mark = "◆" if shaded or not is_map else "▸ ▴"
    console.print(f"{mark} member {best}, the best: {command('play', run.path, '--member', best)}")
