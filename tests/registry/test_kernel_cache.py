"""Kernels compile even if no cache can be written."""

import errno
import os
import sys
from importlib import import_module, invalidate_caches
from pathlib import Path
from unittest.mock import Mock

import pytest
from numba import config
from numba.core.caching import CacheImpl, IndexDataCacheFile

from gaitsim.registry import kernel_cache
from gaitsim.registry.kernel_cache import allow_missing_cache, missing_cache

KERNEL = """
from numba import njit
@njit(cache=True)
def double(x):
    return 2 * x
"""


@pytest.fixture
def nowhere(monkeypatch):
    """Numba can write its cache nowhere but in the folder that this is called with."""
    monkeypatch.setattr(CacheImpl, "_locator_classes", CacheImpl._locator_classes[:1])
    allow_missing_cache()

    def keep_in(folder):
        monkeypatch.setattr(config, "CACHE_DIR", str(folder))
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(folder))  # read again by every compilation
        return folder

    keep_in("")
    return keep_in


def test_kernels_compile_without_a_cache_with_one_warning(nowhere, install):
    for name in ("kernels_a", "kernels_b"):
        install(name, KERNEL)
        assert import_module(name).double(3) == 6
    assert "set NUMBA_CACHE_DIR to a writable folder" in missing_cache()
    assert not missing_cache()
    assert [*Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.nbi")]  # for worker processes


def test_a_cache_that_is_full_or_damaged_is_left_alone(nowhere, install, tmp_path, monkeypatch):
    cache = nowhere(tmp_path / "cache")
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    install("kernels_d", KERNEL)
    kernels = import_module("kernels_d")
    with monkeypatch.context() as patch:
        patch.setattr(IndexDataCacheFile, "save", Mock(side_effect=full))
        assert kernels.double(3) == 6
    assert "No space left" in missing_cache()
    assert import_module("kernels_d").double(3.0) == 6.0  # of another type, so compiled again
    install("kernels_e", KERNEL)
    assert import_module("kernels_e").double(3) == 6
    (index,) = cache.rglob("kernels_e*.nbi")
    index.write_bytes(b"")
    assert import_module("kernels_e").double(3.0) == 6.0
    assert str(index.parent) in missing_cache()


def test_the_stamp_of_a_kernel_changes_with_portable_arithmetic(tmp_path, monkeypatch):
    (tmp_path / "scalar.py").write_text("")
    monkeypatch.setattr(kernel_cache, "_PORTABLE", tmp_path)
    before = kernel_cache._stamp(tmp_path / "elsewhere")
    (tmp_path / "scalar.py").write_text("changed")
    assert kernel_cache._stamp(tmp_path / "elsewhere") != before


def test_a_kernel_is_recompiled_when_a_file_beside_it_changes(nowhere, install, tmp_path):
    nowhere(tmp_path / "cache")
    kernel = "from helper_f import inner\n" + KERNEL.replace("2 * x", "inner(x)")
    helper = "from numba import njit\n@njit\ndef inner(x):\n    return {} * x\n"
    folder = install("kernels_f", kernel)
    for factor in (2, 10):
        (folder / "helper_f.py").write_text(helper.format(factor))
        for name in ("kernels_f", "helper_f"):
            sys.modules.pop(name, None)
        invalidate_caches()
        assert import_module("kernels_f").double(3) == 3 * factor
