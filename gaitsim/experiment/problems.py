"""The problems of an experiment, collected so that one message reports all of them."""

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from gaitsim.errors import GaitsimError, nearest
from gaitsim.registry import options
from gaitsim.toml import is_long, literal, shortened

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
        found: problems in the order in which they were reported.
    """

    def __init__(
        self, source: str, overrides: Overrides | None = None, place: str = COMMAND_LINE
    ) -> None:
        self.source, self.place = source, place
        self.overrides = {str(key): value for key, value in (overrides or {}).items()}
        self.found: list[GaitsimError] = []

    def where(self, key: str) -> str:
        """Return the location of a key, for messages."""
        given = any(key == one or key.startswith(f"{one}.") for one in self.overrides)
        return f"{self.place if given else self.source}, key {key}"

    def typed(self, key: str) -> Typed | None:
        """Return the text that the user typed for a key; None if there is none."""
        value = self.overrides.get(key)
        return value if isinstance(value, Typed) else None

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
        typed = self.typed(key)
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
