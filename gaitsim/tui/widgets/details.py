"""What a run is, in a few lines; why there is none."""

from collections.abc import Mapping
from pathlib import Path

from rich.text import Text

from gaitsim.errors import GaitsimError
from gaitsim.registry import KINDS
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.overview import Overview
from gaitsim.tui.formatting import duration


def details(run: Overview, colours: Mapping[str, str]) -> Text:
    """Its name and description, its plugins, seed, stage and time; or what is wrong with it.

    Args:
        run: the run.
        colours: by the name of the theme's variable.
    """
    head = Text.assemble((visible(run.name), "bold"), "  ", (visible(run.description), ""))
    if run.problem is not None:
        return Text.assemble(head, "\n", (visible_lines(str(run.problem)), colours["error"]))
    plugins = "  ".join(run.plugins.get(kind, "?") for kind in KINDS)
    facts = [f"seed {run.seed}", f"evolved for {duration(run.seconds)}"]
    if run.stage > 1:
        facts.append(f"stage {run.stage}")
    lines = (head, (visible(plugins), colours["secondary"]), ("  ·  ".join(facts), "dim"))
    return Text("\n").join(line if isinstance(line, Text) else Text(*line) for line in lines)


def no_runs(
    folder: Path, count: int, words: str, problem: GaitsimError | None, colours: Mapping[str, str]
) -> Text:
    """Why no run is shown.

    Args:
        folder: where they would be.
        count: how many there are.
        words: that they should have.
        problem: why the folder cannot be read.
        colours: by the name of the theme's variable.
    """
    if problem is not None:
        return Text(visible_lines(str(problem)), style=colours["error"])
    if count:
        return Text(f"None of {count} runs has the words “{words}”.")
    return Text.assemble(
        (f"No runs in {folder} yet.\n\n", "bold"),
        "Press ",
        ("n", "bold"),
        " to assemble one, or in a terminal:\n\ngaitsim run spider",
        justify="center",
    )
