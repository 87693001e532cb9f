"""Overrides: options of an experiment that a user changes before it is validated."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.errors import ExperimentError, GaitsimError, nearest
from gaitsim.experiment.model import Evolution, Islands
from gaitsim.experiment.problems import COMMAND_LINE, Overrides, Problems, Typed
from gaitsim.experiment.transferability import TRANSFERABILITY, Transferability
from gaitsim.experiment.worlds import Worlds
from gaitsim.registry import KINDS, options
from gaitsim.registry.options import PLUGIN
from gaitsim.toml import literal, text

HEAD = ("schema", "name", "description", "seed")
SECTIONS = ("evolution", "islands", "worlds", TRANSFERABILITY, *KINDS)
_EXAMPLE = "SECTION.OPTION=VALUE, such as mutation.rate=0.1"


def parse_assignments(texts: Iterable[str]) -> dict[str, Typed]:
    """Parse texts of the form KEY=VALUE; the last value of a repeated key counts."""
    found: dict[str, Typed] = {}
    problems = []
    for assignment in texts:
        key, equals, value = assignment.partition("=")
        key, value = key.strip(), value.strip()
        if not (equals and all(key.split("."))):
            what = f"{literal(assignment)} is not KEY=VALUE"
            problems.append(GaitsimError(what, where=COMMAND_LINE, allowed=_EXAMPLE))
        elif not _is_unicode(assignment):
            what = f"{assignment!a} is not valid UTF-8"
            problems.append(GaitsimError(what, where=COMMAND_LINE))
        else:
            found[key] = Typed(value)
    if problems:
        raise ExperimentError(problems)
    return found


def apply_overrides(data: dict[str, Any], problems: Problems) -> None:
    """Apply the overrides of `problems` to the tables of an experiment, `data`."""
    for key, value in problems.overrides.items():
        if not _is_unicode(f"{key}={text(value)}"):
            what = f"{key!a} is not valid UTF-8"
            problems.found.append(GaitsimError(what, where=problems.place))
        else:
            _assign(data, key, value, problems)


def _is_unicode(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:  # undecodable bytes of the command line
        return False
    return True


def _assign(data: dict[str, Any], key: str, given: Any, problems: Problems) -> None:
    value = options.parse_value(str(given)) if isinstance(given, Typed) else _plain(given)
    *tables, name = key.split(".")
    if not tables:
        if name in SECTIONS:
            problems.report(key, f"{literal(name)} is a section, not an option", _EXAMPLE)
        elif name in HEAD:
            data[name] = value
        else:
            problems.add_unknown_key("", name, [*HEAD, *SECTIONS], _suggest_section(data, name))
        return
    if tables[0] not in SECTIONS:
        remedy = nearest(tables[0], SECTIONS)
        problems.report(key, f"unknown section {literal(tables[0])}", ", ".join(SECTIONS), remedy)
        return
    table = data
    for depth, part in enumerate(tables, start=1):
        inner = table.setdefault(part, {})
        if not isinstance(inner, dict):
            outer = ".".join(tables[:depth])
            # A section of the wrong type in the file is reported elsewhere.
            if depth > 1:
                problems.report(key, f"{literal(outer)} is an option, not a section", _EXAMPLE)
            return
        table = inner
    if len(tables) == 1 and name == PLUGIN and tables[0] in KINDS:
        # Names of plugins are strings, even 'none' or '2'.
        plugin = str(given) if isinstance(given, Typed) and not isinstance(value, str) else value
        _choose(table, tables[0], plugin, problems.overrides)
    else:
        table[name] = value


def _plain(value: Any) -> Any:
    """Convert a value to TOML types; paths and integers beyond 64 bits become strings."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, Mapping):
        return {str(name): _plain(item) for name, item in value.items()}
    too_long = isinstance(value, int) and not -(2**63) <= value < 2**63
    return str(value) if too_long or isinstance(value, Path) else value


def _choose(table: dict[str, Any], section: str, name: Any, overrides: Overrides) -> None:
    """Choose another plugin, and drop the options of the previous one."""
    if table.get(PLUGIN) == name:
        return
    overridden = {key: item for key, item in table.items() if f"{section}.{key}" in overrides}
    table.clear()
    table.update(overridden)
    table[PLUGIN] = name


def _suggest_section(data: dict[str, Any], name: str) -> str:
    """Return 'did you mean …?' for an option given without its section; '' for other names."""
    options_of = {"evolution": Evolution.model_fields, "islands": Islands.model_fields}
    options_of["worlds"] = Worlds.model_fields
    options_of[TRANSFERABILITY] = Transferability.model_fields
    options_of |= {kind: data[kind] for kind in KINDS if isinstance(data.get(kind), dict)}
    owners = [section for section, known in options_of.items() if name in known]
    return f"did you mean {f'{owners[0]}.{name}'!r}?" if owners else ""
