"""The reference of the installed plugins and their options, generated from their classes."""

import html
from collections.abc import Iterator

from pydantic import BaseModel

from gaitsim.contracts import Organism
from gaitsim.experiment import Evolution
from gaitsim.registry import PLUGINS, entries, load_class, options

HEAD = """# Plugins and their options

This page is generated from the plugins in the gaitsim package; `gaitsim plugins show NAME` prints
the same text. Set an option in the section of the experiment file that is named after the plugin's
kind, or with `--set`, as in `--set search.restarts=bipop`. Options of a reflex are in the option
`reflexes` of its body, and those of plots and exporters are flags.
"""
TITLES = {
    "organism": "Bodies",
    "fitness": "Fitness functions",
    "search": "Searches",
    "selection": "Selections",
    "crossover": "Crossovers",
    "mutation": "Mutations",
    "reflex": "Reflexes",
    "plot": "Plots",
    "exporter": "Exporters",
}


def page() -> str:
    """Return the page in Markdown: all plugins by kind, each with a table of its options."""
    parts = [HEAD, "## Every run: `evolution`", "", *_table(Evolution)]
    for kind in PLUGINS:
        parts += [f"## {TITLES[kind]}: `{kind}`", ""]
        for name in entries(kind):
            plugin = load_class(kind, name)
            about = (plugin.__doc__ or "").strip().split("\n\n")[0]
            parts += [f"### {name}", "", html.escape(" ".join(about.split()), quote=False), ""]
            if kind in ("fitness", "reflex"):
                needs = ", ".join(f"`{one}`" for one in getattr(plugin, "needs", ()))
                what = "channels" if kind == "fitness" else "observations"
                parts += [f"Reads the {what} {needs}.", ""]
            parts += _table(plugin)
            if issubclass(plugin, Organism):
                parts += _channels(plugin)
    return "\n".join(parts) + "\n"


def _channels(body: type[Organism]) -> Iterator[str]:
    yield "| channel | meaning | axes | unit |\n| --- | --- | --- | --- |"
    for name, channel in body.channels.items():
        yield f"| `{name}` | {channel.help} | {channel.shape} | {channel.units} |"
    yield ""


def _table(model: type[BaseModel]) -> Iterator[str]:
    if not model.model_fields:
        yield "No options.\n"
        return
    yield "| option | meaning | allowed | default |\n| --- | --- | --- | --- |"
    for name, field in model.model_fields.items():
        texts = (options.meaning(field), options.allowed(field))
        meaning, allowed = (html.escape(one, quote=False).replace("|", "&#124;") for one in texts)
        yield f"| `{name}` | {meaning} | {allowed} | `{options.default(field)}` |"
    yield ""
