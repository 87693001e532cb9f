"""Overrides, options of an experiment that a user changes; problems, collected for one message."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from gaitsim.errors import ExperimentError, GaitsimError, nearest
from gaitsim.experiment.model import (
    CONSTRAINTS,
    TRANSFERABILITY,
    Constraints,
    Evolution,
    Islands,
    Transferability,
    Worlds,
)
from gaitsim.registry import KINDS, options
from gaitsim.registry.options import PLUGIN
from gaitsim.toml import is_long, literal, shortened, text

COMMAND_LINE = "command line"

Overrides = Mapping[str, Any]
"""Values of options by key, such as `{"mutation.rate": 0.1}`."""


class Typed(str):
    """The value of an option as typed by the user; its meaning depends on the option."""

    __slots__ = ()


# Types of pydantic's errors whose messages are more precise than the option's type and bounds.
_SELF_EXPLANATORY = ("value_error", "assertion_error", "string_pattern_mismatch")


class Problems:
    """Collects the problems of an experiment.

    Attributes:
        source: name of the file or preset, for messages.
        overrides: values of options that override those of the source, by key.
        place: origin of the overrides, for messages.
        typed: the overrides that the user typed, as texts.
        found: problems in the order in which they were reported.
    """

    def __init__(
        self, source: str, overrides: Overrides | None = None, place: str = COMMAND_LINE
    ) -> None:
        self.source, self.place = source, place
        self.overrides = {str(key): value for key, value in (overrides or {}).items()}
        self.typed = {key: one for key, one in self.overrides.items() if isinstance(one, Typed)}
        self.found: list[GaitsimError] = []

    def where(self, key: str) -> str:
        """Return the location of a key, for messages."""
        given = any(key == one or key.startswith(f"{one}.") for one in self.overrides)
        return f"{self.place if given else self.source}, key {key}"

    def report(self, key: str, what: str, allowed: str = "", remedy: str = "") -> None:
        """Record a problem with a key."""
        self.found.append(
            GaitsimError(what, where=self.where(key), allowed=allowed, remedy=remedy, key=key)
        )

    def add_plugin_error(self, key: str, error: GaitsimError) -> None:
        """Record an error of the plugin that the value of a key names."""
        error.where = f"{self.where(key)}: {error.where}" if error.where else self.where(key)
        error.key = key
        self.found.append(error)

    @contextmanager
    def recorded(self, key: str) -> Iterator[None]:
        """Record an error of the plugin that the value of a key names, if the block raises one."""
        try:
            yield
        except GaitsimError as error:
            self.add_plugin_error(key, error)

    def add_option_errors(
        self, section: str, model: type[BaseModel], data: Mapping[str, Any], error: ValidationError
    ) -> None:
        """Record the validation errors of a section, at most one per option."""
        seen = set()
        for detail in error.errors(include_url=False):
            name = str(detail["loc"][0]) if detail["loc"] else ""
            if name and name in seen:  # pydantic reports each member of a union
                continue
            seen.add(name)
            if detail["type"] == "extra_forbidden" and len(detail["loc"]) == 1:
                self.add_unknown_key(section, name, list(model.model_fields))
            elif name in model.model_fields:
                field = model.model_fields[name]
                self._add_option_error(f"{section}.{name}", field, data.get(name), detail)
            else:
                self._add_section_error(section, _sentence(detail))

    def _add_section_error(self, section: str, what: str) -> None:
        """Record options that are valid one by one, but not together."""
        changed = [key for key in self.overrides if key.startswith(f"{section}.")]
        also = f", with {', '.join(changed)} from the {self.place}" if changed else ""
        where = f"{self.source}, section {section}{also}"
        self.found.append(GaitsimError(what, where=where, key=section))

    def _add_option_error(self, key: str, field: FieldInfo, given: Any, detail: Any) -> None:
        # Show the text as typed: TOML would read 1e3 as 1000.0.
        typed = self.typed.get(key)
        shown = literal(given) if typed is None or is_long(typed) else shortened(typed or '""')
        if detail["type"] == "missing" and len(detail["loc"]) == 1:
            what = missing_option(key, field)
        elif detail["type"] in _SELF_EXPLANATORY:
            what = invalid_value(key, shown, _sentence(detail))
        elif detail["type"] == "finite_number":
            what = invalid_value(key, f"{shown} is not finite", options.meaning(field))
        else:
            what = invalid_value(key, shown, options.meaning(field))
        choices = options.string_choices(field) if isinstance(given, str) else []
        self.report(
            key,
            what,
            "" if detail["type"] in _SELF_EXPLANATORY else options.allowed(field),
            nearest(str(given), choices),
        )

    def add_unknown_key(
        self, section: str, name: str, known: Iterable[str], remedy: str = ""
    ) -> None:
        """Record an unknown key."""
        key = f"{section}.{name}" if section else name
        names = sorted(known)
        self.report(
            key,
            f"unknown key {literal(name)}",
            ", ".join(names) or "none",
            remedy or nearest(name, names),
        )


def missing_option(key: str, field: FieldInfo) -> str:
    """Return the message that an option without a default is missing."""
    about = options.meaning(field)
    return f"{key} is required ({about})" if about else f"{key} is required"


def invalid_value(key: str, shown: str, about: str = "") -> str:
    """Return the message about an invalid value, followed by the meaning of the key or a reason."""
    return f"invalid {key}: {shown} ({about})" if about else f"invalid {key}: {shown}"


def _sentence(detail: Any) -> str:
    message = str(detail["msg"])
    return message.removeprefix("Value error, ").removeprefix("Assertion failed, ")


HEAD = ("schema", "name", "description", "seed")
SECTIONS = ("evolution", "islands", "worlds", TRANSFERABILITY, CONSTRAINTS, *KINDS)
_EXAMPLE = "SECTION.OPTION=VALUE, such as fitness.yaw_weight=8"


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
    options_of[CONSTRAINTS] = Constraints.model_fields
    options_of |= {kind: data[kind] for kind in KINDS if isinstance(data.get(kind), dict)}
    owners = [section for section, known in options_of.items() if name in known]
    return f"did you mean {f'{owners[0]}.{name}'!r}?" if owners else ""
