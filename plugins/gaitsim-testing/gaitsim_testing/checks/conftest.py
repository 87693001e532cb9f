"""Fixtures of all checks: the plugin, imported and with its options."""

import random
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from gaitsim.plugin import Entry, Plugin, load_entry, plugin_errors
from gaitsim_testing.finding import advise, require
from gaitsim_testing.plugin import Checks
from gaitsim_testing.trials import build_plugin, with_placeholders

SLOW_IMPORT = 3.0  # seconds, without the libraries that gaitsim itself imports


@pytest.fixture(scope="session")
def model(entry: Entry) -> type[Plugin]:
    """The class of the plugin, whose import must be quick."""
    new = entry.target.partition(":")[0] not in sys.modules
    start = time.perf_counter()
    found = load_entry(entry)
    seconds = time.perf_counter() - start
    advise(
        not new or seconds <= SLOW_IMPORT,
        f"the import takes {seconds:.1f} s",
        f"at most {SLOW_IMPORT:g} s",
        "import heavy libraries inside functions, and compute nothing at import",
    )
    return found


@pytest.fixture(scope="session")
def options(request: pytest.FixtureRequest) -> dict[str, Any]:
    """The options that differ from the defaults."""
    return _checks(request).options


@pytest.fixture(scope="session")
def plugin(entry: Entry, model: type[Plugin], options: dict[str, Any]) -> Plugin:
    """The plugin with its options."""
    values = with_placeholders(model, options)
    with plugin_errors(entry, "validating its options"):
        # Options are validated as in a file. Without options, the plugin is created as in Python,
        # which does not validate defaults.
        return build_plugin(model, values) if values else model()


def _checks(request: pytest.FixtureRequest) -> Checks:
    checks = request.config.pluginmanager.get_plugin("gaitsim-checks")
    assert isinstance(checks, Checks)
    return checks


@pytest.fixture
def passed(request: pytest.FixtureRequest, entry: Entry, plugin: Plugin) -> None:
    """Skip the check if an earlier one failed."""
    if _checks(request).has_failed(entry):
        pytest.skip("an earlier check of the plugin failed")


@pytest.fixture(autouse=True)
def _no_global_randomness() -> Iterator[None]:
    before = _global_random_state()
    yield
    require(
        _global_random_state() == before,
        "the plugin draws from 'random' or 'numpy.random'",
        "random numbers only from given generators, because runs must be reproducible",
        "draw from the argument 'rng', or from np.random.default_rng(seed)",
    )


def _global_random_state() -> tuple[object, ...]:
    _, keys, *rest = np.random.get_state()  # noqa: NPY002 - to detect its use
    return random.getstate(), np.asarray(keys).tobytes(), *rest
