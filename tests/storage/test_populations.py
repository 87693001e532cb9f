"""A run keeps whole populations at an interval of generations."""

from dataclasses import replace

import numpy as np
import pytest
from run_helpers import LONG, THRESHOLD, continue_run

from gaitsim.errors import RunError
from gaitsim.storage.creation import create_run, fork_run
from gaitsim.storage.files.checkpoint import pack, read_checkpoint
from gaitsim.storage.files.folder import kept_populations, population_file
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import verify

pytestmark = pytest.mark.usefixtures("here")


@pytest.fixture
def kept(puppet):
    path = create_run(puppet(LONG, THRESHOLD, "evolution.keep_every=3"))
    continue_run(path)
    return RunSnapshot(path)


def test_populations_are_kept_and_read(kept, whole):
    assert kept_populations(kept.path) == [3, 6]
    assert kept.fingerprint() == whole.fingerprint()
    for generation in (3, 6, kept.generation, None):
        population = kept.population(generation)
        number = generation or kept.generation
        assert population.generation == number
        assert population.scores.max() == kept.history["best"][number - 1]
        best = population.genomes[population.scores.argmax()]
        assert np.array_equal(best, kept.bests[number - 1]["genome"])
    with pytest.raises(RunError, match="did not keep the population of generation 2") as error:
        kept.population(2)
    assert error.value.allowed == f"3, 6, {kept.generation}"


def test_later_populations_are_dropped_when_a_run_resumes(kept):
    late = kept.path / population_file(9)
    late.write_bytes((kept.path / population_file(6)).read_bytes())
    assert 9 not in fork_populations(kept.path)
    continue_run(kept.path, generations=9)
    assert read_checkpoint(late).generation == 9
    assert verify(RunSnapshot(kept.path), workers=1).identical


def fork_populations(path):
    return kept_populations(fork_run(path))


def test_a_kept_population_is_compared(kept):
    file = kept.path / population_file(6)
    population = read_checkpoint(file)
    file.write_bytes(pack(replace(population, genomes=population.genomes + 1e-9)))
    what = verify(kept, workers=1).differences[6][0]
    assert "the genomes in populations/" in what
    (kept.path / population_file(3)).write_bytes(file.read_bytes())
    assert "of generation 6" in verify(kept, workers=1).differences[3][0]
    with pytest.raises(RunError, match="does not belong to the run"):
        kept.population(3)
