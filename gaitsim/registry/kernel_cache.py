"""Compiled kernels where none can be kept: bodies run, and compile at each start.

Numba refuses to compile a function with `cache=True` if it can write neither beside the function's
module nor in the user's cache folder, as in a container or an installation by an administrator. A
folder of this process replaces the cache there. Numba also fails if the cache is full or damaged.
"""

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from functools import partial, wraps
from pathlib import Path
from typing import Any

_LOCATORS = "NUMBA_CACHE_LOCATOR_CLASSES"
_OTHER = "set NUMBA_CACHE_DIR to a folder that may be written"
_problems: list[str] = []


class KernelCache:
    """Locates the cache of a function as Numba does, or else in a temporary folder."""

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> Any:
        """Return Numba's locator for a function of a file."""
        config = sys.modules["numba"].config
        _tolerate_errors()
        found = _locator(py_func, py_file)
        if found is None:
            folder = tempfile.mkdtemp(prefix="gaitsim-kernels-")
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            # Also for worker processes, which then need not compile again.
            os.environ["NUMBA_CACHE_DIR"] = config.CACHE_DIR = folder
            _problems.append(f"compiled kernels cannot be kept for the next start: {_OTHER}")
            found = _locator(py_func, py_file)
        if found is not None:
            found.get_source_stamp = partial(_stamp, Path(py_file).parent)
        return found


def _stamp(folder: Path) -> list[tuple[str, int, int]]:
    """Return what changes with any source file beside a kernel.

    Numba looks at the kernel's own file alone, and would keep a kernel whose helpers changed.
    """
    files = [(path.name, path.stat()) for path in sorted(folder.glob("*.py"))]
    return [(name, found.st_mtime_ns, found.st_size) for name, found in files]


def _tolerate_errors() -> None:
    """Let Numba compile a function whose cache cannot be read or written."""
    from numba.core.caching import Cache

    def tolerant(method: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(method)
        def call(cache: Any, *arguments: Any) -> Any:
            try:
                return method(cache, *arguments)
            except Exception as error:  # whatever pickle raises for a damaged file
                cache.disable()
                reason = f"{type(error).__name__}: {error}"
                where = f"compiled kernels cannot be kept in {cache.cache_path}"
                _problems.append(f"{where} ({reason}): delete it, or {_OTHER}")
                return None

        return call

    for name in ("load_overload", "save_overload"):
        method = getattr(Cache, name)
        if not hasattr(method, "__wrapped__"):
            setattr(Cache, name, tolerant(method))


def _locator(py_func: Callable[..., Any], py_file: str) -> Any:
    from numba.core.caching import CacheImpl

    classes: list[Any] = CacheImpl._locator_classes
    tried = (one.from_function(py_func, py_file) for one in classes)
    return next((found for found in tried if found is not None), None)


def allow_missing_cache() -> None:
    """Let kernels compile where Numba's cache cannot be written; a second call does nothing.

    It also lets a kernel be compiled again when a file beside its own has changed.
    """
    name = f"{__name__}.{KernelCache.__name__}"
    os.environ.setdefault(_LOCATORS, name)
    config: Any = getattr(sys.modules.get("numba"), "config", None)
    if not getattr(config, "CACHE_LOCATOR_CLASSES", name):  # Numba was imported before
        config.CACHE_LOCATOR_CLASSES = name


def missing_cache() -> str:
    """Return once that compiled kernels are not kept; '' where they are, or from then on."""
    found = [*_problems]
    _problems.clear()
    return found[0] if found else ""
