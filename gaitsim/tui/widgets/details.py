"""What a run is, in a few lines."""

from collections.abc import Mapping

from rich.text import Text

from gaitsim.registry import KINDS
from gaitsim.runs.overview import Overview
from gaitsim.tui.words import duration, visible


def details(run: Overview, colours: Mapping[str, str]) -> Text:
    """Its name and description, its plugins, seed, stage and time; or what is wrong with it.

    Args:
        run: the run.
        colours: by the name of the theme's variable.
    """
    head = Text.assemble((visible(run.name), "bold"), "  ", (visible(run.description), ""))
    if run.problem is not None:
        return Text.assemble(head, "\n", (str(run.problem), colours["error"]))
    plugins = "  ".join(run.plugins.get(kind, "?") for kind in KINDS)
    facts = [f"seed {run.seed}", f"evolved for {duration(run.seconds)}"]
    if run.stage > 1:
        facts.append(f"stage {run.stage}")
    lines = (head, (visible(plugins), colours["secondary"]), ("  ·  ".join(facts), "dim"))
    return Text("\n").join(line if isinstance(line, Text) else Text(*line) for line in lines)
