"""A dry run of a checkpoint's pickle, which follows its opcodes without building anything."""

MAX_DEPTH = 16
"""Maximum depth of nested containers."""

# A value that an opcode puts on the unpickler's stack: its type, and its depth in containers.
_Value = tuple[type, int]
_PUSHES: dict[str, _Value] = {
    "EMPTY_DICT": (dict, 1),
    "EMPTY_LIST": (list, 1),
    **dict.fromkeys(("SHORT_BINUNICODE", "BINUNICODE", "BINUNICODE8"), (str, 0)),
    **dict.fromkeys(("SHORT_BINBYTES", "BINBYTES", "BINBYTES8"), (bytes, 0)),
    **dict.fromkeys(("BININT", "BININT1", "BININT2", "LONG1"), (int, 0)),
    **dict.fromkeys(("NONE", "NEWTRUE", "NEWFALSE", "BINFLOAT"), (object, 0)),
}
# Opcodes that move values from the stack into the container below them: the type of the
# container, and for two of them the number of values. A mark gives the start for the others.
_FILLS: dict[str, type] = {"APPEND": list, "APPENDS": list, "SETITEM": dict, "SETITEMS": dict}
_WIDTHS = {"APPEND": 1, "SETITEM": 2}


class RejectedPickleError(Exception):
    """Raised for a pickle that is rejected; the message is the reason."""


class OpcodeStack:
    """The unpickler's stack, with the type and depth of each value instead of the value."""

    def __init__(self) -> None:
        self.values: list[_Value] = []
        self.marks: list[int] = []

    def follow(self, name: str) -> None:
        """Apply the effect of an opcode to the stack."""
        if name in _PUSHES:
            self.values.append(_PUSHES[name])
        elif name == "MARK":
            self.marks.append(len(self.values))
        elif name in _WIDTHS:
            self._fill(_FILLS[name], len(self.values) - _WIDTHS[name])
        elif name in _FILLS:
            self._fill(_FILLS[name], self.marks.pop() if self.marks else 0)
        elif name not in ("FRAME", "STOP"):
            raise RejectedPickleError(f"it contains the opcode {name}, which no checkpoint has")

    def _fill(self, container: type, start: int) -> None:
        """Move the values from `start` on into the container below them."""
        if start < 1 or self.values[start - 1][0] is not container:
            raise RejectedPickleError(f"it fills a {container.__name__} that does not exist")
        items = self.values[start:]
        if container is dict and (len(items) % 2 or any(kind is not str for kind, _ in items[::2])):
            raise RejectedPickleError("a key is not a string")
        depth = max([self.values[start - 1][1], *(inner + 1 for _, inner in items)])
        if depth > MAX_DEPTH:
            raise RejectedPickleError(f"its containers are nested more than {MAX_DEPTH} deep")
        self.values[start - 1 :] = [(container, depth)]
