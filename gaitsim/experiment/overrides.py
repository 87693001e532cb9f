"""What a command line changes in an experiment's values, before they are checked."""

from collections.abc import Sequence
from typing import Any

from gaitsim.errors import GaitsimError, nearest
from gaitsim.experiment.problems import Problems
from gaitsim.registry import KINDS, options
from gaitsim.registry.class_validation import PLUGIN
from gaitsim.toml import literal

HEAD = ("schema", "name", "description", "seed")
SECTIONS = ("evolution", "islands", *KINDS)
_EXAMPLE = "as mutation.rate=0.1"


def override(data: dict[str, Any], overrides: Sequence[str], problems: Problems) -> None:
    """Change `data` by assignments, 'KEY=VALUE' each; of equal keys, the last one counts."""
    for text in overrides:
        try:
            key, typed = options.parse_assignment(text)
        except ValueError as error:
            problems.found.append(GaitsimError(str(error), where="command line", allowed=_EXAMPLE))
            continue
        if not _is_unicode(text):
            problems.found.append(
                GaitsimError(f"{text!a} is not text in UTF-8", where="command line")
            )
            continue
        problems.typed[key] = typed
        _assign(data, key, typed, problems)


def _is_unicode(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:  # bytes of the command line that are no characters
        return False
    return True


def _assign(data: dict[str, Any], key: str, typed: str, problems: Problems) -> None:
    *tables, name = key.split(".")
    if not tables:
        if name in SECTIONS:
            problems.report(key, f"{literal(name)} is a section, not an option", _EXAMPLE)
        elif name in HEAD:
            data[name] = options.parse_value(typed)
        else:
            problems.unknown("", name, [*HEAD, *SECTIONS], _owner(data, name))
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
            # A section of a wrong type in the file is told there.
            if depth > 1:
                problems.report(key, f"{literal(outer)} is an option, not a section", _EXAMPLE)
            return
        table = inner
    if tables == [key.rpartition(".")[0]] and name == PLUGIN and tables[0] in KINDS:
        _choose(table, tables[0], typed, problems)
    else:
        table[name] = options.parse_value(typed)


def _choose(table: dict[str, Any], section: str, typed: str, problems: Problems) -> None:
    """Choose another plugin; the old one's options mean nothing to it."""
    value = options.parse_value(typed)
    # Names are texts; one like 'none' or '2' is, too.
    name = value if isinstance(value, str) else typed
    if table.get(PLUGIN) == name:
        return
    kept = {key: item for key, item in table.items() if f"{section}.{key}" in problems.typed}
    table.clear()
    table.update(kept)
    table[PLUGIN] = name


def _owner(data: dict[str, Any], name: str) -> str:
    """'did you mean …?' for an option given without its section, or ''."""
    from gaitsim.experiment.model import Evolution, Islands

    owners = ["evolution"] if name in Evolution.model_fields else []
    owners += ["islands"] if name in Islands.model_fields else []
    owners += [kind for kind in KINDS if isinstance(data.get(kind), dict) and name in data[kind]]
    return f"did you mean {f'{owners[0]}.{name}'!r}?" if owners else ""
