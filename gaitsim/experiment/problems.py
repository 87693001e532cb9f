"""The problems of one experiment, collected so that all are reported at once."""

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from gaitsim.errors import GaitsimError, nearest
from gaitsim.registry import options
from gaitsim.toml import literal, shortened

# What an error of pydantic says when its own words tell more than the option's type and bounds.
_TELLING = ("value_error", "assertion_error", "string_pattern_mismatch")


class Problems:
    """Collects what is wrong with an experiment.

    Attributes:
        source: the file or preset, as told in messages.
        typed: what a command line gives, by key; the text as it was typed.
        found: the problems, in the order in which they were met.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        self.typed: dict[str, str] = {}
        self.found: list[GaitsimError] = []

    def where(self, key: str) -> str:
        """Where a key stands."""
        return f"{'command line' if key in self.typed else self.source}, key {key}"

    def report(self, key: str, what: str, allowed: str = "", remedy: str = "") -> None:
        """Take note of a problem with a key."""
        self.found.append(
            GaitsimError(what, where=self.where(key), allowed=allowed, remedy=remedy, key=key)
        )

    def of_plugin(self, key: str, error: GaitsimError) -> None:
        """Take note of what a plugin that a key chooses has raised."""
        where = f"{self.where(key)}: {error.where}" if error.where else self.where(key)
        self.found.append(
            type(error)(
                error.what, where=where, allowed=error.allowed, remedy=error.remedy, key=key
            )
        )

    def of_options(
        self, section: str, model: type[BaseModel], data: Mapping[str, Any], error: ValidationError
    ) -> None:
        """Take note of all that pydantic refuses in a section, each option once."""
        met = set()
        for detail in error.errors(include_url=False):
            name = str(detail["loc"][0]) if detail["loc"] else ""
            if name and name in met:  # as of each member of a union
                continue
            met.add(name)
            if detail["type"] == "extra_forbidden" and len(detail["loc"]) == 1:
                self.unknown(section, name, list(model.model_fields))
            elif name in model.model_fields:
                field = model.model_fields[name]
                self._of_option(f"{section}.{name}", field, data.get(name), detail)
            else:
                self._of_section(section, _sentence(detail))

    def _of_section(self, section: str, what: str) -> None:
        """Options that are allowed one by one, but not together."""
        changed = [key for key in self.typed if key.startswith(f"{section}.")]
        also = f", with {', '.join(changed)} of the command line" if changed else ""
        where = f"{self.source}, section {section}{also}"
        self.found.append(GaitsimError(what, where=where, key=section))

    def _of_option(self, key: str, field: FieldInfo, given: Any, detail: Any) -> None:
        about = options.meaning(field)
        # As it was typed: TOML would read 1e3 as 1000.0.
        shown = shortened(self.typed[key] or '""') if key in self.typed else literal(given)
        if detail["type"] == "missing" and len(detail["loc"]) == 1:
            what = f"{key} is required"
        elif detail["type"] in _TELLING:
            what = f"{shown} is not allowed: {_sentence(detail)}"
            about = ""
        elif detail["type"] == "finite_number":
            what = f"{shown} is not a finite number"
        else:
            what = f"{shown} is not allowed"
        choices = options.words(field) if isinstance(given, str) else []
        self.report(
            key,
            f"{what}: {about}" if about else what,
            options.allowed(field),
            nearest(str(given), choices),
        )

    def unknown(self, section: str, name: str, known: Iterable[str], remedy: str = "") -> None:
        """Take note of a key that does not exist."""
        key = f"{section}.{name}" if section else name
        names = sorted(known)
        self.report(
            key,
            f"unknown key {literal(name)}",
            ", ".join(names) or "none",
            remedy or nearest(name, names),
        )


def _sentence(detail: Any) -> str:
    message = str(detail["msg"])
    return message.removeprefix("Value error, ").removeprefix("Assertion failed, ")
