"""Errors that users and plugin authors can cause and correct, and functions that create them."""

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any


class GaitsimError(Exception):
    """An error that the reader of the message can correct.

    The command line prints it without a traceback and exits with code 2.

    Args:
        what: description of the error, one sentence.
        where: file, key or plugin with the error.
        allowed: allowed values.
        remedy: suggested correction.
        key: wrong key of an experiment, study or settings file, such as `mutation.rate`, or its
            section, such as `mutation`; `''` if there is none. It is meant for programs; messages
            name it in `where`.
    """

    def __init__(
        self, what: str, *, where: str = "", allowed: str = "", remedy: str = "", key: str = ""
    ) -> None:
        self.what = what
        self.where = where
        self.allowed = allowed
        self.remedy = remedy
        self.key = key
        super().__init__(what, where, allowed, remedy, key)

    def __str__(self) -> str:
        lines = [self.what]
        for label, text in (
            ("where", self.where),
            ("allowed", self.allowed),
            ("try", self.remedy),
        ):
            if text:
                lines.append(f"  {label + ':':<9}{text}")
        return "\n".join(lines)

    def add_remedy(self, remedy: str) -> None:
        """Append a remedy to the existing one, if any."""
        self.remedy = f"{self.remedy}; then {remedy}" if self.remedy else remedy

    def to_dict(self) -> dict[str, Any]:
        """Return the parts as JSON values, which `error_from_dict` reads."""
        names = ("what", "where", "key", "allowed", "remedy")
        return {name: getattr(self, name) for name in names}

    def __reduce__(self) -> tuple[object, ...]:
        # Errors are pickled by worker processes, and the default pickling loses keyword-only
        # arguments.
        state = (self.what, self.where, self.allowed, self.remedy, self.key)
        return (_rebuild, (type(self), *state))


def _rebuild(
    kind: type[GaitsimError], what: str, where: str, allowed: str, remedy: str, key: str
) -> GaitsimError:
    error = kind.__new__(kind)
    GaitsimError.__init__(error, what, where=where, allowed=allowed, remedy=remedy, key=key)
    return error


class PluginError(GaitsimError):
    """A plugin is missing or broken, or breaks its contract; the message names its package."""


class ContractError(PluginError):
    """A plugin fails or breaks its contract."""


class MissingFunctionError(PluginError):
    """An experiment uses a Python function or object that was not given to this process."""


class RunError(GaitsimError):
    """The run folder cannot be created, read, written or resumed."""


class NothingToPlotError(GaitsimError):
    """A run, body or motion lacks the data for a kind of plot."""


class CheckpointError(RunError):
    """A checkpoint is missing, damaged, hostile, of the wrong kind or in another format."""


class ExperimentError(GaitsimError):
    """An experiment has problems, which are all reported at once.

    Args:
        problems: all problems found, in the order of the file.
        noun: name of the thing that has problems, such as 'experiment'.
    """

    def __init__(self, problems: Sequence[GaitsimError], noun: str = "experiment") -> None:
        self.problems = tuple(problems)
        self.noun = noun
        count = len(self.problems)
        super().__init__(
            f"the {noun} has a problem" if count == 1 else f"the {noun} has {count} problems"
        )

    def __str__(self) -> str:
        return "\n".join([f"{self.what}:", *(f"- {problem}" for problem in self.problems)])

    def to_dict(self) -> dict[str, Any]:
        """Return the parts, the noun, and the parts of each problem."""
        problems = [problem.to_dict() for problem in self.problems]
        return super().to_dict() | {"noun": self.noun, "problems": problems}

    def __reduce__(self) -> tuple[object, ...]:
        return (ExperimentError, (self.problems, self.noun))


def error_from_dict(data: Mapping[str, Any]) -> GaitsimError:
    """Return the error with the parts of `GaitsimError.to_dict`.

    Raises:
        KeyError: a part is missing.
        TypeError: a part is not a string.
    """
    parts = {name: data[name] for name in ("where", "allowed", "remedy", "key")}
    if not all(isinstance(part, str) for part in (data["what"], *parts.values())):
        raise TypeError("a part is not a string")
    if "problems" not in data:
        return GaitsimError(data["what"], **parts)
    found = ExperimentError([error_from_dict(one) for one in data["problems"]], data["noun"])
    for name, text in parts.items():
        setattr(found, name, text)
    return found


def nearest(word: str, known: Sequence[str], cutoff: float = 0.6) -> str:
    """Return 'did you mean …?' with the known word most similar to `word`, or ''."""
    matches = get_close_matches(word, known, n=1, cutoff=cutoff)
    return f"did you mean {matches[0]!r}?" if matches else ""


def unknown(
    what: str, name: str, known: Iterable[str], *, where: str = "", key: str = ""
) -> GaitsimError:
    """Return the error of an unknown name, which lists the known ones."""
    names = list(known)
    return GaitsimError(
        f"unknown {what} {name!r:.200}",
        where=where,
        allowed=", ".join(names),
        remedy=nearest(name, names),
        key=key,
    )


def unsupported_flags(
    subject: str, flags: Sequence[str], switch: str, choices: Sequence[str], **places: str
) -> GaitsimError:
    """Return the error about flags that one choice of a switch does not support.

    Args:
        subject: the choice, such as "the format 'mat'".
        flags: the unsupported flags, such as `--clip`.
        switch: the flag that makes the choice, such as `--format`.
        choices: the choices that support all the flags.
        places: `where` or `allowed` of the error.
    """
    named = " and ".join(flags)
    other = f", or use {switch} {', '.join(choices)}" if choices else ""
    what = f"{subject} has no option{'s' if len(flags) > 1 else ''} {named}"
    return GaitsimError(what, remedy=f"omit {named}{other}", **places)


def not_installed(
    what: str, package: str | None, extra: str, *, source: str = "gaitsim", where: str = ""
) -> GaitsimError:
    """Return the error of a missing package that an extra of gaitsim installs.

    Args:
        what: feature that needs the package.
        package: name of the package.
        extra: name of the extra.
        source: distribution that has the extra.
        where: place of the error, as in `GaitsimError`.
    """
    return GaitsimError(
        f"{what} needs the package {package}, which is not installed",
        where=where,
        remedy=f"pip install '{source}[{extra}]'",
    )
