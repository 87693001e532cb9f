"""Calls into plugins: which one is at work, and errors that name its package."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import NamedTuple, NoReturn

from gaitsim.errors import ContractError, GaitsimError
from gaitsim.registry.entry_points import Entry


class _Call(NamedTuple):
    entry: Entry
    doing: str
    process: int
    thread: int


# Of the whole process, as Ctrl-C is: plugins may be at work in any thread.
_active: dict[object, _Call] = {}  # in order of entry, by a key that compares by identity
_interrupted: list[_Call] = []


@contextmanager
def plugin_context(entry: Entry, doing: str) -> Iterator[None]:
    """Note which plugin is at work, for `interrupted_plugin`.

    A copy of this process that the plugin made by `os.fork` ends with the block: it would write
    to the run beside this process, and release its locks.

    Args:
        entry: the plugin.
        doing: its task, such as 'moving a population'.
    """
    key, call = object(), _Call(entry, doing, os.getpid(), threading.get_ident())
    _active[key] = call
    try:
        yield
    except KeyboardInterrupt:
        _interrupted.append(call)
        raise
    finally:
        del _active[key]
        if os.getpid() != call.process:
            text = f"{entry} copied this process by os.fork while {doing}; the copy is ended"
            with suppress(OSError):
                os.write(2, f"Warning: {text}\n".encode())  # a lock of sys.stderr may be held
            _end_process(2)


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
            _check_descriptors(entry, doing)
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
            failed = contract_error(entry, f"failed while {doing}: {reason}")
            failed.where = entry.place_of(error)
            raise failed from error


def contract_error(entry: Entry, what: str, allowed: str = "") -> ContractError:
    """Return the error of a plugin that fails or breaks its contract; it names the package."""
    return ContractError(
        f"{entry} {what}", where=entry.target, allowed=allowed, remedy=entry.remedy
    )


def interrupted_plugin() -> str:
    """Return which plugin Ctrl-C interrupted and its task, once; '' if none was at work."""
    # The innermost call was left first; other threads may still be in theirs.
    calls = [*_interrupted[:1], *list(_active.values())[-1:]]
    _interrupted.clear()
    return f"{calls[0].entry} was {calls[0].doing}" if calls else ""


_end_process = os._exit
_errors: list[int] = []  # a copy of standard error


def guard_process() -> None:
    """Keep plugins from ending the process or closing its output; a second call does nothing.

    `os._exit` raises SystemExit in a plugin, so that it is reported and the run is closed.
    """
    if os._exit is not _exit:
        os._exit = _exit
        with suppress(OSError):  # closed by the caller
            _errors.append(os.dup(2))


def _exit(status: int) -> NoReturn:
    here = os.getpid(), threading.get_ident()
    if any((call.process, call.thread) == here for call in [*_active.values()]):
        raise SystemExit(f"os._exit({status})")
    _end_process(status)


def _check_descriptors(entry: Entry, doing: str) -> None:
    """Refuse that a plugin closed standard output or error: files opened next would get it."""
    closed = [number for number in (1, 2) if _errors and not _is_open(number)]
    for number in closed:
        with suppress(OSError):
            os.dup2(_errors[0], number)
    if closed:
        names = " and ".join(f"the descriptor {number}" for number in closed)
        raise contract_error(entry, f"closed {names} while {doing}", "only files that it opened")


def _is_open(descriptor: int) -> bool:
    try:
        os.get_inheritable(descriptor)  # unlike fstat it keeps the lock of Python: it never waits
    except OSError:
        return False
    return True
