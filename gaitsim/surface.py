"""Public modules whose names are listed in a stub and imported at first use."""

import re
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

_IMPORT = re.compile(r"^from (\S+) import (?:\(([^)]*)\)|(.*))$", re.MULTILINE)
_NAME = re.compile(r"(\w+) as (\w+)")


def offer(module: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a module that imports the names of its stub.

    The stub imports each name as `from MODULE import NAME as NAME`, so that type checkers and this
    function read the same list.

    Args:
        module: name of the public module.
        file: its path; the stub is beside it.
    """

    @cache
    def names() -> dict[str, tuple[str, str]]:
        stub = Path(file).with_suffix(".pyi").read_text(encoding="utf-8")
        return {
            public: (origin, name)
            for origin, several, one in _IMPORT.findall(stub)
            for name, public in _NAME.findall(several or one)
        }

    def load(name: str) -> Any:
        if name not in names():
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        origin, own = names()[name]
        parent = import_module(origin)
        found = getattr(parent, own) if hasattr(parent, own) else import_module(f"{origin}.{own}")
        setattr(sys.modules[module], name, found)
        return found

    return load, lambda: [*names()]
