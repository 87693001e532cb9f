"""The reference of all installed plugins and their options, made of their declarations."""

import html
from collections.abc import Iterator

from pydantic import BaseModel

from gaitsim.contracts import Organism
from gaitsim.experiment import Evolution
from gaitsim.registry import KINDS, entries, load_class, options

HEAD = """# Plugins and their options

Made from the plugins that gaitsim ships; `gaitsim plugins show NAME` says the same in the terminal.
An option stands in an experiment's section of the plugin's kind, or after `--set`, as in
`--set mutation.rate=0.1`.
"""
TITLES = {
    "organism": "Bodies",
    "fitness": "Fitness functions",
    "search": "Searches",
    "selection": "Selections",
    "crossover": "Crossovers",
    "mutation": "Mutations",
}


def page() -> str:
    """The page in Markdown: every plugin, by kind, with a table of its options."""
    parts = [HEAD, "## Every run: `evolution`", "", *_table(Evolution)]
    for kind in KINDS:
        parts += [f"## {TITLES[kind]}: `{kind}`", ""]
        for name in entries(kind):
            plugin = load_class(kind, name)
            about = (plugin.__doc__ or "").strip().split("\n\n")[0]
            parts += [f"### {name}", "", html.escape(" ".join(about.split()), quote=False), ""]
            if kind == "fitness":
                needs = ", ".join(f"`{channel}`" for channel in getattr(plugin, "needs", ()))
                parts += [f"Reads the channels {needs}.", ""]
            parts += _table(plugin)
            if issubclass(plugin, Organism):
                parts += _channels(plugin)
    return "\n".join(parts) + "\n"


def _channels(body: type[Organism]) -> Iterator[str]:
    yield "| channel | what it is | axes | unit |\n| --- | --- | --- | --- |"
    for name, channel in body.channels.items():
        yield f"| `{name}` | {channel.help} | {channel.shape} | {channel.units} |"
    yield ""


def _table(model: type[BaseModel]) -> Iterator[str]:
    if not model.model_fields:
        yield "No options.\n"
        return
    yield "| option | what it is | allowed | default |\n| --- | --- | --- | --- |"
    for name, field in model.model_fields.items():
        words = (options.meaning(field), options.allowed(field))
        meaning, allowed = (html.escape(one, quote=False).replace("|", "&#124;") for one in words)
        yield f"| `{name}` | {meaning} | {allowed} | `{options.default(field)}` |"
    yield ""
