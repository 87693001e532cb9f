"""One page with a line for everything: commands, Python names, presets, bodies, plots, formats."""

import html
import inspect
import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path

import commands
import numpy as np
import parts
from typer.main import get_command

import gaitsim as gs
from gaitsim.cli.app import app
from gaitsim.registry import EXPERIMENTS, entries, load_class
from gaitsim.registry.loading import describe_preset

HEAD = """# Everything in one page

This page is generated: each line links to more. In Python, `import gaitsim as gs`.
"""
DOCS = Path(__file__).parents[1] / "docs"
OBJECTS = {"run": gs.Run, "search": gs.RunningSearch, "individual": gs.Individual}


def page(documented: Mapping[str, str]) -> str:
    """Return the page in Markdown.

    Args:
        documented: pages of the documented Python objects, by their full names.
    """
    sections = {
        "Commands": _commands(),
        "Python": _python(documented),
        "Presets": _presets(),
        **dict(_bodies()),
        "Plots": _plugins("plot"),
        "Export formats": _plugins("exporter"),
    }
    lines = [HEAD]
    for title, rows in sections.items():
        lines += [f"## {title}", "", *(f"- {row}" for row in rows), ""]
    return "\n".join(lines)


def _commands() -> Iterator[str]:
    for name, function in commands.commands(get_command(app), "gaitsim"):
        yield _line(f"[`{name}`](commands.md#{name.replace(' ', '-')})", function.__doc__)


def _python(documented: Mapping[str, str]) -> Iterator[str]:
    pages = {path.rpartition(".")[2]: f"{page}#{path}" for path, page in documented.items()}
    for name in sorted(gs.__all__, key=str.lower):
        shown = f"`gs.{name}`"
        yield _line(
            f"[{shown}]({pages[name]})" if name in pages else shown, getattr(gs, name).__doc__
        )
    for short, found in OBJECTS.items():
        members = {name: one.__doc__ for name, one in inspect.getmembers(found, _is_public)}
        for one in reversed(found.__mro__):
            members |= _attributes(one)
        for name, text in sorted(members.items()):
            if not name.startswith("_"):
                yield _line(f"[`{short}.{name}`]({pages[found.__name__]})", text)


def _attributes(found: type) -> dict[str, str]:
    """Return the attributes that the docstring of a class lists, with their descriptions."""
    section = inspect.cleandoc(found.__doc__ or "").partition("Attributes:\n")[2]
    return dict(re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", section.partition("\n\n")[0], re.M))


def _is_public(member: object) -> bool:
    return callable(member) or isinstance(member, property | cached_property)


def _presets() -> Iterator[str]:
    for name in entries(EXPERIMENTS):
        body = gs.load_experiment(name).entries["organism"].name
        yield _line(f"[`{name}`]({_page_of(body)})", describe_preset(name))


def _bodies() -> Iterator[tuple[str, list[str]]]:
    """Yield the channels and measures of each body, moved once."""
    for body in entries("organism"):
        experiment = gs.load_experiment("hexapod" if body == "robot" else body)
        genome = experiment.space().random(1, np.random.default_rng(0))[0]
        moved = gs.Individual(experiment, 0.0, {}, genome=genome)
        options, about = f"parts.md#{body}", type(experiment.organism).__doc__
        rows = [_line(f"[`{body}`]({_page_of(body)})", f"{about}")]
        for name, one in experiment.organism.channels.items():
            rows.append(f"channel [`{name}`]({options}) {html.escape(str(one), quote=False)}")
        for name, value in moved.measurements.items():
            unit = f", {value.unit}" if value.unit else ""
            rows.append(_line(f"measure [`{name}`]({_page_of(body)}){unit}", value.help))
        yield f"Body: {body}", rows


def _plugins(kind: str) -> Iterator[str]:
    # Headings that occur twice on a page get numbers.
    titles = re.findall(r"^#+ (.*)$", parts.page(), re.MULTILINE)
    first = titles.index(f"{parts.TITLES[kind]}: `{kind}`")
    for name in entries(kind):
        before = titles[: titles.index(name, first)].count(name)
        anchor = name if not before else f"{name}_{before}"
        yield _line(f"[`{name}`](parts.md#{anchor})", load_class(kind, name).__doc__)


def _page_of(body: str) -> str:
    return f"{body}.md" if (DOCS / f"{body}.md").exists() else "robots.md"


def _line(name: str, text: str | None) -> str:
    about = " ".join(inspect.cleandoc(text or "").split("\n\n")[0].split())
    return f"{name}: {html.escape(about, quote=False)}"
