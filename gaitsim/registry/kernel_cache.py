"""Compile kernels even if Numba's cache is unusable; kernels then compile at each start.

Numba refuses to compile a function with `cache=True` if it can write neither beside the function's
module nor to the user's cache folder, for example in a container or an installation by an
administrator. A temporary folder then replaces the cache. Numba also fails if the cache is full or
damaged.
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
_REMEDY = "set NUMBA_CACHE_DIR to a writable folder"
_PORTABLE = Path(__file__).parents[1] / "portable"
_problems: list[str] = []


class KernelCache:
    """A locator of Numba's cache that falls back to a temporary folder."""

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> Any:
        """Return Numba's locator for a function in a file."""
        config = sys.modules["numba"].config
        _tolerate_errors()
        found = _locator(py_func, py_file)
        if found is None:
            folder = tempfile.mkdtemp(prefix="gaitsim-kernels-")
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            # Worker processes inherit the folder, so they need not compile.
            os.environ["NUMBA_CACHE_DIR"] = config.CACHE_DIR = folder
            _problems.append(f"compiled kernels cannot be cached for the next start: {_REMEDY}")
            found = _locator(py_func, py_file)
        if found is not None:
            found.get_source_stamp = partial(_stamp, Path(py_file).parent)
        return found


def _stamp(folder: Path) -> list[tuple[str, int, int]]:
    """Return a stamp that changes with any source file beside a kernel and of `gaitsim.portable`.

    Numba checks only the kernel's own file, and would keep a kernel whose helpers have changed.
    """
    files = [
        (path.name, path.stat())
        for sources in (folder, _PORTABLE)
        for path in sorted(sources.glob("*.py"))
    ]
    return [(name, found.st_mtime_ns, found.st_size) for name, found in files]


def _tolerate_errors() -> None:
    """Make Numba compile a function even if its cache cannot be read or written."""
    from numba.core.caching import Cache

    def tolerant(method: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(method)
        def call(cache: Any, *arguments: Any) -> Any:
            try:
                return method(cache, *arguments)
            except Exception as error:  # pickle raises any type for a damaged file
                cache.disable()
                reason = f"{type(error).__name__}: {error}"
                where = f"compiled kernels cannot be cached in {cache.cache_path}"
                _problems.append(f"{where} ({reason}): delete this folder, or {_REMEDY}")
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
    """Let kernels compile even if Numba's cache is not writable; further calls do nothing.

    Kernels are also recompiled when a file beside their own has changed.
    """
    name = f"{__name__}.{KernelCache.__name__}"
    os.environ.setdefault(_LOCATORS, name)
    config: Any = getattr(sys.modules.get("numba"), "config", None)
    if not getattr(config, "CACHE_LOCATOR_CLASSES", name):  # Numba has already been imported
        config.CACHE_LOCATOR_CLASSES = name


def missing_cache() -> str:
    """Return a warning, once, if compiled kernels cannot be cached; otherwise ''."""
    found = [*_problems]
    _problems.clear()
    return found[0] if found else ""
