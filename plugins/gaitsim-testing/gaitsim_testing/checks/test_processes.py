"""Check that the results of a plugin do not depend on the process."""

import os
from collections.abc import Iterator
from multiprocessing import get_context
from multiprocessing.pool import Pool
from typing import Any

import pytest

from gaitsim.plugin import KINDS as _KINDS, REFLEX, Entry
from gaitsim_testing.finding import require
from gaitsim_testing.results import digest_results

KINDS = (*_KINDS, REFLEX)  # files of products contain times


@pytest.fixture(scope="session")
def another_process() -> Iterator[Pool]:
    """A process with another order of sets."""
    seed = "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONHASHSEED", seed)
        pool = get_context("spawn").Pool(1)
    yield pool
    pool.terminate()


def test_another_process(
    entry: Entry, passed: object, options: dict[str, Any], another_process: Pool
) -> None:
    """Another process computes the same bits as this one, if all other checks passed."""
    require(
        another_process.apply(digest_results, [entry, options]) == digest_results(entry, options),
        "different bits in another process, such as a worker",
        "the same bits in every process",
        "depend only on options and genomes: not on the order of a set, on id() or hash(), "
        "the environment, or earlier results",
    )
