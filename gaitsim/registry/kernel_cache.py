"""Compiled kernels where none can be kept: a folder of this process replaces Numba's cache.

Numba refuses to compile a function with `cache=True` if it can write neither beside the function's
module nor in the user's cache folder, as in a container or an installation by an administrator.
"""

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from typing import Any

_LOCATORS = "NUMBA_CACHE_LOCATOR_CLASSES"
_told: list[str] = []


class KernelCache:
    """Locates the cache of a function as Numba does, or else in a temporary folder."""

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> Any:
        """Return Numba's locator for a function of a file."""
        config = sys.modules["numba"].config

        found = _locator(py_func, py_file)
        if found is None:
            folder = tempfile.mkdtemp(prefix="gaitsim-kernels-")
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            # Also for worker processes, which then need not compile again.
            os.environ["NUMBA_CACHE_DIR"] = config.CACHE_DIR = folder
            _told.append(
                "compiled kernels cannot be kept, so each start compiles them again: set "
                "NUMBA_CACHE_DIR to a folder that may be written"
            )
            found = _locator(py_func, py_file)
        return found


def _locator(py_func: Callable[..., Any], py_file: str) -> Any:
    from numba.core.caching import CacheImpl

    classes: list[Any] = CacheImpl._locator_classes
    tried = (one.from_function(py_func, py_file) for one in classes)
    return next((found for found in tried if found is not None), None)


def allow_missing_cache() -> None:
    """Let kernels compile where Numba's cache cannot be written; a second call does nothing."""
    name = f"{__name__}.{KernelCache.__name__}"
    os.environ.setdefault(_LOCATORS, name)
    config: Any = getattr(sys.modules.get("numba"), "config", None)
    if not getattr(config, "CACHE_LOCATOR_CLASSES", name):  # Numba was imported before
        config.CACHE_LOCATOR_CLASSES = name


def missing_cache() -> str:
    """Return once that compiled kernels are not kept; '' where they are, or from then on."""
    return _told.pop() if _told else ""
