"""A description of a run in a few lines, or the reason why no run is shown."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from rich.cells import cell_len
from rich.text import Text

from gaitsim.errors import GaitsimError
from gaitsim.registry import KINDS
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.overview import Overview
from gaitsim.tui.formatting import duration

LINES = 3  # maximum lines of a note
SEPARATOR = "  ·  "


def details(run: Overview, colours: Mapping[str, str], width: int) -> Text:
    """Return the name, description, note, plugins, seed, stage and time of a run, or its problems.

    Args:
        run: the run.
        colours: colours by the name of the theme's variable.
        width: width of a line, cells.
    """
    name = Text.assemble((visible(run.name), "bold"), "  ", (visible(run.description), ""))
    lines = [name, *(Text(visible(line), style="italic") for line in _first_lines(run.note))]
    for error in filter(None, (run.problem, run.failure)):
        lines.append(Text(visible_lines(str(error)), style=colours["error"]))
    if run.problem is None:
        plugins = [
            visible(f"{'body' if kind == 'organism' else kind} {run.plugins[kind]}")
            for kind in KINDS
            if kind in run.plugins
        ]
        facts = [f"seed {run.seed}", f"evolved for {duration(run.seconds)}"]
        if run.stage > 1:
            facts.append(f"stage {run.stage}")
        lines += [
            Text("\n".join(_lines(plugins, width)), style=colours["secondary"]),
            Text(SEPARATOR.join(facts), style="dim"),
        ]
    return Text("\n").join(lines)


def _lines(facts: Iterable[str], width: int) -> list[str]:
    """Join facts to lines of a width, without breaks within a fact."""
    lines: list[str] = []
    for fact in facts:
        longer = f"{lines[-1]}{SEPARATOR}{fact}" if lines else fact
        if lines and cell_len(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(fact)
    return lines


def _first_lines(note: str) -> list[str]:
    """Return the first lines of a note."""
    lines = note.splitlines()
    return lines if len(lines) <= LINES else [*lines[: LINES - 1], f"{lines[LINES - 1]} …"]


def no_runs(
    folder: Path, count: int, words: str, problem: GaitsimError | None, colours: Mapping[str, str]
) -> Text:
    """Return the reason why no run is shown.

    Args:
        folder: folder of runs.
        count: number of runs.
        words: words of the filter.
        problem: reason why the folder cannot be read; None if it can be read.
        colours: colours by the name of the theme's variable.
    """
    if problem is not None:
        return Text(visible_lines(str(problem)), style=colours["error"])
    if count:
        return Text(f"None of the {count} runs matches “{words}”.")
    return Text.assemble(
        (f"There are no runs in {folder}/ yet.\n\n", "bold"),
        "Press ",
        ("n", "bold"),
        " to create one, or in a terminal:\n\ngaitsim run spider",
        justify="center",
    )
