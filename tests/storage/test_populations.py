"""A run keeps whole populations at an interval of generations."""

from dataclasses import replace

import numpy as np
import pytest
from run_helpers import LONG, THRESHOLD, continue_run

from gaitsim.errors import RunError
from gaitsim.storage.creation import create_run, fork_run
from gaitsim.storage.files.checkpoint import pack, read_checkpoint
from gaitsim.storage.files.folder import POPULATIONS, kept_file, kept_generations
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import populations, verify_run

pytestmark = pytest.mark.usefixtures("here")


@pytest.fixture
def kept(puppet):
    path = create_run(puppet(LONG, THRESHOLD, "evolution.keep_every=3"))
    continue_run(path)
    return RunSnapshot(path)


def test_populations_are_kept_and_read(kept, whole):
    assert kept_generations(kept.path, POPULATIONS) == [3, 6]
    assert kept.fingerprint() == whole.fingerprint()
    for generation in (3, 6, kept.generation):
        population = kept.population(generation)
        assert population.generation == generation
        assert population.scores.max() == kept.history["best"][generation - 1]
        best = population.genomes[population.scores.argmax()]
        assert np.array_equal(best, kept.bests[generation - 1]["genome"])


def test_others_are_evolved_again_from_the_nearest_kept_one(kept):
    began, advanced = [], []
    (kept.path / kept_file(POPULATIONS, 3)).unlink()
    found = [*populations(kept, [2, 5, 6, 7], began.append, advanced.append)]
    size = kept.experiment.evolution.population
    assert [generation.number for generation in found] == [2, 5, 6, 7]
    assert began == [sum(advanced)] == [6 * size]  # 1 to 5, and 7
    for generation in found:
        best = kept.bests[generation.number - 1]["genome"]
        assert np.array_equal(generation.genomes[generation.best], best)


def test_some_populations_are_always_kept(puppet):
    path = create_run(puppet("evolution.generations=200", "evolution.population=4"))
    continue_run(path)
    assert kept_generations(path, POPULATIONS) == [100]  # and the last, as the checkpoint
    continue_run(path, generations=201)
    assert kept_generations(path, POPULATIONS) == [100]


def test_later_populations_are_dropped_when_a_run_resumes(kept):
    late = kept.path / kept_file(POPULATIONS, 9)
    late.write_bytes((kept.path / kept_file(POPULATIONS, 6)).read_bytes())
    assert 9 not in fork_populations(kept.path)
    continue_run(kept.path, generations=9)
    assert read_checkpoint(late).generation == 9
    assert verify_run(RunSnapshot(kept.path), workers=1).identical


def fork_populations(path):
    return kept_generations(fork_run(path), POPULATIONS)


def test_a_kept_population_is_compared(kept):
    file = kept.path / kept_file(POPULATIONS, 6)
    population = read_checkpoint(file)
    file.write_bytes(pack(replace(population, genomes=population.genomes + 1e-9)))
    found = verify_run(kept, workers=1).differences[0]
    assert (found.file, found.generation) == (kept_file(POPULATIONS, 6), 6)
    assert "the genomes do not match" in found.what
    with pytest.raises(RunError, match="differs from the record in populations: its genomes"):
        next(populations(kept, [6]))
    file.unlink()
    (again,) = populations(kept, [6])
    assert np.array_equal(again.genomes, population.genomes)
    file.write_bytes(pack(population))
    (kept.path / kept_file(POPULATIONS, 3)).write_bytes(file.read_bytes())
    assert "of generation 6" in verify_run(kept, workers=1).differences[0].what
    with pytest.raises(RunError, match="does not belong to the run"):
        kept.population(3)
