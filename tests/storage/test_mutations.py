"""Readers of a run's files return or raise one clear error, whatever the files contain."""

from contextlib import suppress

import pytest
from mutations import mutations, mutations_of_values
from run_helpers import THRESHOLD, continue_run, seal

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.storage.compatibility import check_start
from gaitsim.storage.creation import champion_of, create_run
from gaitsim.storage.files import safe_pickle
from gaitsim.storage.files.checkpoint import read_champion
from gaitsim.storage.files.history import read_history, read_islands, read_records
from gaitsim.storage.files.records import RECORD
from gaitsim.storage.provenance import read_provenance
from gaitsim.storage.snapshot import RunSnapshot

pytestmark = pytest.mark.usefixtures("here")

ISLANDS = "islands.number=2"


@pytest.fixture
def run(puppet, tmp_path):
    """A run of three generations on two islands that started from an individual."""
    path = create_run(puppet(ISLANDS), tmp_path / "first")
    continue_run(path, 1)
    start = champion_of(RunSnapshot(path))
    path = create_run(puppet(ISLANDS, THRESHOLD), tmp_path / "run", start)
    continue_run(path, 3)
    return RunSnapshot(path)


def read_start(run, path):
    start = RunSnapshot(run.path).start
    check_start(run.experiment, start, str(path))


def read_best(run, path):
    run.__dict__.pop("bests", None)
    run.individual()


READERS = {
    "experiment.toml": lambda run, path: load_experiment(str(path)),
    "outline": lambda run, path: RunSnapshot(run.path).outline,
    "history.csv": lambda run, path: read_history(path, 3),
    "islands.csv": lambda run, path: read_islands(path, 2, 3),
    "bests.bin": read_best,
    "checksums.bin": lambda run, path: read_records(path, RECORD, 3),
    "provenance.json": lambda run, path: read_provenance(run.path),
    "population.pickle": lambda run, path: RunSnapshot(run.path).stages,
    "champions/generation-000001.pickle": lambda run, path: read_champion(path),
    "start.pickle": read_start,
}


def changed_files(path, count):
    """Yield mutations of a file; of a checkpoint, most have a right checksum."""
    data = path.read_bytes()
    if path.suffix != ".pickle":
        yield from mutations(data, count)
        return
    content = safe_pickle.load(path)
    yield from mutations(data, count // 5)
    for payload in mutations(data[safe_pickle.HEADER :], count * 2 // 5):
        yield seal(payload)
    for values in mutations_of_values(content, count - count // 5 - count * 2 // 5):
        with suppress(ValueError):
            yield safe_pickle.dumps(values)


def check(run, name, count):
    path = run.path / ("experiment.toml" if name == "outline" else name)
    valid = path.read_bytes()
    READERS[name](run, path)
    for data in changed_files(path, count):
        path.write_bytes(data)
        try:
            READERS[name](run, path)
        except GaitsimError:
            continue
        except Exception as error:
            raise AssertionError(f"{name} fell over {data[:2000]!r}") from error
    path.write_bytes(valid)


def test_mutated_files_are_read_or_rejected(run):
    for name in READERS:
        check(run, name, 50)


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_many_mutated_files_are_read_or_rejected(run, name):
    check(run, name, 500)
