"""Kernels compile where no cache can be written."""

import os
from importlib import import_module
from pathlib import Path

import pytest
from numba import config
from numba.core.caching import CacheImpl

from gaitsim.registry.kernel_cache import allow_missing_cache, missing_cache

KERNEL = """
from numba import njit
@njit(cache=True)
def double(x):
    return 2 * x
"""


@pytest.fixture
def nowhere(monkeypatch):
    """Numba can write its cache only where the user says."""
    monkeypatch.setattr(CacheImpl, "_locator_classes", CacheImpl._locator_classes[:1])
    monkeypatch.setattr(config, "CACHE_DIR", "")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    allow_missing_cache()


def test_kernels_compile_without_a_cache_and_that_is_said_once(nowhere, install):
    for name in ("kernels_a", "kernels_b"):
        install(name, KERNEL)
        assert import_module(name).double(3) == 6
    assert "set NUMBA_CACHE_DIR to a folder that may be written" in missing_cache()
    assert not missing_cache()
    assert [*Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.nbi")]  # for worker processes


def test_a_cache_that_can_be_written_is_used(nowhere, install, tmp_path, monkeypatch):
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    install("kernels_c", KERNEL)
    assert import_module("kernels_c").double(3) == 6
    assert not missing_cache()
    assert [*(tmp_path / "cache").rglob("*.nbi")]
