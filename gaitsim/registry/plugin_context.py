"""Calls into plugins: which one is at work, and errors that name its package."""

from collections.abc import Iterator
from contextlib import contextmanager

from gaitsim.errors import ContractError, GaitsimError
from gaitsim.registry.entry_points import Entry

_Call = tuple[Entry, str]

# Of the whole process, as Ctrl-C is: plugins may be at work in any thread.
_active: dict[object, _Call] = {}  # in order of entry, by a key that compares by identity
_interrupted: list[_Call] = []


@contextmanager
def plugin_context(entry: Entry, doing: str) -> Iterator[None]:
    """Note which plugin is at work, for `interrupted_plugin`.

    Args:
        entry: the plugin.
        doing: its task, such as 'moving a population'.
    """
    key = object()
    _active[key] = entry, doing
    try:
        yield
    except KeyboardInterrupt:
        _interrupted.append((entry, doing))
        raise
    finally:
        del _active[key]


@contextmanager
def plugin_errors(entry: Entry, doing: str) -> Iterator[None]:
    """Turn whatever a plugin raises into a `GaitsimError` that names its package.

    Args:
        entry: the plugin.
        doing: its task, such as 'moving a population'.
    """
    with plugin_context(entry, doing):
        try:
            yield
        except GaitsimError as error:
            error.where = error.where or f"{entry}, {entry.target}"
            raise
        except (KeyboardInterrupt, GeneratorExit):
            raise
        except BaseException as error:  # SystemExit, too: a plugin does not end the program
            try:
                reason = f"{type(error).__name__}: {error}".rstrip(": ")
            except Exception:  # `__str__` is the plugin's code, too
                reason = type(error).__name__
            raise contract_error(entry, f"failed while {doing}: {reason}") from error


def contract_error(entry: Entry, what: str, allowed: str = "") -> ContractError:
    """Return the error of a plugin that fails or breaks its contract; it names the package."""
    return ContractError(
        f"{entry} {what}",
        where=entry.target,
        allowed=allowed,
        remedy=f"update {entry.package}, or report it to its author",
    )


def interrupted_plugin() -> str:
    """Return which plugin Ctrl-C interrupted and its task, once; '' if none was at work."""
    # The innermost call was left first; other threads may still be in theirs.
    calls = [*_interrupted[:1], *list(_active.values())[-1:]]
    _interrupted.clear()
    return f"{calls[0][0]} was {calls[0][1]}" if calls else ""
