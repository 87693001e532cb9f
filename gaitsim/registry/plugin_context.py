"""Which plugin each thread is in. What a plugin prints goes to standard error meanwhile.

Standard output is for results: a line that a body prints would spoil `--json`. What other
threads print, such as a progress display, goes where it always does.
"""

import sys
import threading
from types import TracebackType
from typing import Any

_lock = threading.Lock()
_stacks: dict[int, list[tuple[object, str]]] = {}
_interrupted: list[tuple[object, str]] = []


_watched: list[bool] = []


def leave_together() -> None:
    """From here on leave what plugins print in standard output, for who looks at that."""
    _watched.append(True)


class _Parted:
    """Standard output, but standard error for threads that are in a plugin.

    Args:
        stream: where everybody else prints.
    """

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def _mine(self) -> Any:
        if _watched or threading.get_ident() not in _stacks:
            return self._stream
        return sys.stderr

    def write(self, text: str) -> int:
        """Write to whichever stream is this thread's."""
        stream = self._mine()
        return len(text) if stream is None else int(stream.write(text))

    def writelines(self, lines: Any) -> None:
        """Write each."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Write out what waits."""
        stream = self._mine()
        if stream is not None:
            stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._mine(), name)


class plugin_context:
    """Within, this thread is in a plugin. A class, as it is entered ten times a generation.

    Args:
        plugin: which one.
        doing: what, to be told when the user stops it.
    """

    __slots__ = ("_what",)

    def __init__(self, plugin: object, doing: str) -> None:
        self._what = (plugin, doing)

    def __enter__(self) -> None:
        thread = threading.get_ident()
        with _lock:
            _stacks.setdefault(thread, []).append(self._what)
            if type(sys.stdout) is not _Parted:
                sys.stdout = _Parted(sys.stdout)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is KeyboardInterrupt and not _interrupted:
            _interrupted.append(self._what)
        thread = threading.get_ident()
        with _lock:
            stack = _stacks[thread]
            stack.pop()
            if not stack:
                del _stacks[thread]
            if not _stacks and isinstance(sys.stdout, _Parted):
                sys.stdout = sys.stdout._stream


def stopped() -> str:
    """Which plugin was at work, doing what, when the user stopped it; '' for none."""
    with _lock:
        working = [stack[-1] for stack in _stacks.values()]
    # The innermost was left first; it is told although it is left.
    plugin, doing = next(iter([*_interrupted, *working]), ("", ""))
    _interrupted.clear()
    return f"{plugin} was {doing}" if doing else ""
