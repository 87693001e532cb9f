"""Findings of a check: an error, which fails the test, or advice, which is a warning."""

import warnings
from traceback import walk_tb

from gaitsim.plugin import ContractError, Entry, ExperimentError, GaitsimError


class Advice(UserWarning):
    """A possible improvement of a plugin that fulfils its contract."""


taken: list[str] = []
"""Advice that has not been attached to the report of a test yet."""


def require(fulfilled: object, actual: str, expected: str, fix: str = "") -> None:
    """Raise an error if a rule is broken.

    Args:
        fulfilled: whether the plugin follows the rule.
        actual: behaviour of the plugin, if it does not.
        expected: behaviour that the contract requires.
        fix: change that corrects the plugin.
    """
    if not fulfilled:
        raise GaitsimError(actual, allowed=expected, remedy=fix)


def require_type(method: str, value: object, expected: type) -> None:
    """Raise an error if a method returns something else than an instance of a contract's class."""
    name = f"{expected.__module__.partition('.')[0]}.contracts.{expected.__name__}"
    require(
        isinstance(value, expected),
        f"{method} returns a {type(value).__name__}",
        f"a {name}",
        f"see the docstring of {name}",
    )


def require_unchanged(fulfilled: object, method: str, what: str) -> None:
    """Raise an error if a method changes an argument."""
    require(fulfilled, f"{method} changes {what}", "unchanged arguments", "work on a copy: copy()")


def advise(followed: object, actual: str, expected: str, fix: str) -> None:
    """Warn if a plugin could be improved; the arguments are those of `require`."""
    if not followed:
        text = str(GaitsimError(actual, allowed=expected, remedy=fix))
        taken.append(text)
        warnings.warn(text, Advice, stacklevel=2)


def note_output(text: str) -> None:
    """Advise against the output of a plugin."""
    allowed = "no standard output, because it is reserved for results, such as JSON"
    fix = "use the module logging, or print(…, file=sys.stderr)"
    taken.append(str(GaitsimError(f"prints {text[:200]!r}", allowed=allowed, remedy=fix)))


def explain(entry: Entry, error: BaseException) -> str:
    """Return the message about an exception in a check; one of the plugin names its line."""
    if isinstance(error, GaitsimError):
        found = error
        if isinstance(error, ContractError):  # its remedy is for users, not for plugin authors
            fix = f"see gaitsim.contracts.{entry.kind.capitalize()}"
            found = GaitsimError(error.what, where=error.where, allowed=error.allowed, remedy=fix)
        elif isinstance(error, ExperimentError):
            return str(error)
    else:
        reason = f"{type(error).__name__}: {error}".rstrip(": ")
        found = GaitsimError(reason, allowed="no exception")
    if place := _location(entry, error.__cause__ or error):
        found.where, found.remedy = place, "correct the code at this line"
    elif isinstance(error.__cause__, ModuleNotFoundError):
        found.remedy = f"add the module, or correct the entry point {entry.target!r}"
    return str(found)


def _location(entry: Entry, cause: BaseException) -> str:
    """Return the file and line of the plugin's package that raised an exception, or ''."""
    package = entry.target.partition(":")[0].partition(".")[0]
    place = ""
    for frame, line in walk_tb(cause.__traceback__):
        if str(frame.f_globals.get("__name__")).partition(".")[0] == package:
            place = f"{frame.f_code.co_filename}, line {line}"
    return place


def require_array(
    method: str, what: str, value: object, shape: tuple[int, ...], dtype: object
) -> None:
    """Raise an error if a value is not an array with the expected shape and dtype."""
    expected = f"an array of shape {shape}, dtype {dtype} ({what})"
    found = f"shape {getattr(value, 'shape', '')}, dtype {getattr(value, 'dtype', '')}"
    is_array = type(value).__module__ == "numpy" and hasattr(value, "dtype")
    require(
        is_array and getattr(value, "shape", None) == shape and value.dtype == dtype,  # type: ignore[attr-defined]
        f"{method} returns {found if is_array else f'a {type(value).__name__}'}",
        expected,
        "see the docstring of the method in gaitsim.contracts",
    )
