"""Calls into plugins: track the running plugin, and report errors with its package."""

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


# Shared by all threads, because Ctrl-C stops the process while plugins run in any thread.
_active: dict[object, _Call] = {}  # in order of entry; each key is a unique object
_interrupted: list[_Call] = []


@contextmanager
def plugin_context(entry: Entry, doing: str) -> Iterator[None]:
    """Record which plugin is running, for `interrupted_plugin`.

    If the plugin forks the process with `os.fork`, the child is killed at the end of the block:
    otherwise it would write to the same run and release this process's locks.

    Args:
        entry: entry of the plugin.
        doing: task of the plugin, such as 'moving a population'.
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
            text = f"{entry} called os.fork while {doing}; the child process is killed"
            with suppress(OSError):
                os.write(2, f"Warning: {text}\n".encode())  # the lock of sys.stderr may be held
            _end_process(2)


@contextmanager
def plugin_errors(entry: Entry, doing: str) -> Iterator[None]:
    """Convert any exception of a plugin to a `GaitsimError` that names its package.

    Args:
        entry: entry of the plugin.
        doing: task of the plugin, such as 'moving a population'.
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
        except BaseException as error:  # also SystemExit: a plugin must not end the program
            try:
                reason = f"{type(error).__name__}: {error}".rstrip(": ")
            except Exception:  # `__str__` may be the plugin's code
                reason = type(error).__name__
            failed = contract_error(entry, f"failed while {doing}: {reason}")
            failed.where = entry.place_of(error)
            raise failed from error


def contract_error(entry: Entry, what: str, allowed: str = "") -> ContractError:
    """Return the error for a plugin that fails or breaks its contract; it names the package."""
    return ContractError(
        f"{entry} {what}", where=entry.target, allowed=allowed, remedy=entry.remedy
    )


def interrupted_plugin() -> str:
    """Return the plugin that Ctrl-C interrupted and its task, once; '' if there is none."""
    # The innermost call is recorded first; other threads may still be inside theirs.
    calls = [*_interrupted[:1], *list(_active.values())[-1:]]
    _interrupted.clear()
    return f"{calls[0].entry} was {calls[0].doing}" if calls else ""


_end_process = os._exit
_errors: list[int] = []  # a duplicate of the descriptor of standard error, once guarded


def guard_process() -> None:
    """Keep plugins from ending the process or closing its output; further calls do nothing.

    In a plugin, `os._exit` raises SystemExit, so that gaitsim reports the call and closes the run.
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
    """Raise an error if a plugin closed standard output or error.

    The next file that is opened would reuse the descriptor, and messages would be written to it.
    """
    closed = [number for number in (1, 2) if _errors and not _is_open(number)]
    for number in closed:
        with suppress(OSError):
            os.dup2(_errors[0], number)
    if closed:
        names = " and ".join(f"file descriptor {number}" for number in closed)
        raise contract_error(entry, f"closed {names} while {doing}", "only files that it opened")


def _is_open(descriptor: int) -> bool:
    try:
        # Unlike fstat, this call keeps the interpreter lock, so it never waits.
        os.get_inheritable(descriptor)
    except OSError:
        return False
    return True
