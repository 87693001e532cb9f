"""A run is resumed from its folder, or rejected with one message."""

import os
import shutil

import pytest
from run_helpers import LONG, THRESHOLD, assert_same, continue_run, names, reopen

from gaitsim.errors import CheckpointError, ExperimentError, RunError
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.checkpoint import read_checkpoint, write_checkpoint
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

pytestmark = pytest.mark.usefixtures("here")


def test_a_run_without_its_checkpoints_does_not_start_from_scratch(whole):
    for name in ("population.pickle", "population.previous.pickle"):
        (whole.path / name).unlink()
    before = (whole.path / "history.csv").read_bytes()
    with pytest.raises(CheckpointError, match=r"are missing, but history\.csv has generations"):
        RunSnapshot(whole.path).generation  # noqa: B018
    with pytest.raises(CheckpointError):
        continue_run(whole.path)
    assert (whole.path / "history.csv").read_bytes() == before
    # One row may have been written before a process was killed, without its checkpoint.
    (whole.path / "history.csv").write_bytes(b"\n".join(before.split(b"\n")[:2]) + b"\n")
    assert RunSnapshot(whole.path).generation == 0


@pytest.mark.parametrize("until", [1, 4, 7])
def test_a_resumed_run_is_identical(whole, puppet, until):
    path = create_run(puppet(LONG, THRESHOLD))
    continue_run(path, until)
    assert continue_run(path) == ""
    assert_same(RunSnapshot(path), whole)


@pytest.mark.parametrize("stop", ["stagnation=2", "target_score=2.4", "max_evaluations=40"])
def test_a_resumed_run_stops_at_the_same_generation(puppet, stop):
    overrides = ("evolution.generations=60", f"evolution.{stop}")
    whole = create_run(puppet(*overrides))
    continue_run(whole)
    end = RunSnapshot(whole).generation
    assert 3 < end < 60
    path = create_run(puppet(*overrides))
    for generation in range(1, end + 2):
        continue_run(path, generation)
    assert RunSnapshot(path).generation == end
    assert RunSnapshot(path).fingerprint() == RunSnapshot(whole).fingerprint()


def test_an_extended_run_is_identical(whole, puppet):
    path = create_run(puppet(THRESHOLD, "evolution.generations=3"))
    continue_run(path)
    assert RunSnapshot(path).generation == 3
    assert continue_run(path, generations=8) == ""
    assert RunSnapshot(path).fingerprint() == whole.fingerprint()
    assert RunSnapshot(path).experiment.evolution.generations == 8
    with pytest.raises(RunError, match="is already at generation 8") as error:
        RunWriter.open(path, generations=7)
    assert error.value.allowed == "evolution.generations of 8 or more"
    assert RunSnapshot(path).experiment.evolution.generations == 8


def test_records_past_the_checkpoint_are_cut_off(half, whole):
    fingerprint = half.fingerprint()
    with (half.path / "history.csv").open("a") as file:
        file.write((half.path / "history.csv").read_text().splitlines()[-1].replace("4,", "5,", 1))
        file.write("\n6,1")
    with (half.path / "bests.bin").open("ab") as file:
        file.write(bytes(50))
    shutil.copy(
        sorted((half.path / "champions").iterdir())[0],
        half.path / "champions/generation-000005.pickle",
    )
    (half.path / "champions/generation-mine.pickle").touch()
    read = reopen(half)
    assert read.fingerprint() == fingerprint
    assert len(read.history["best"]) == len(read.bests) == 4
    with RunWriter.open(half.path):
        pass
    assert len((half.path / "history.csv").read_text().splitlines()) == 5
    assert (half.path / "bests.bin").stat().st_size == 4 * 32
    assert "generation-000005.pickle" not in names(half.path / "champions")
    (half.path / "champions/generation-mine.pickle").unlink()
    continue_run(half.path)
    assert_same(half, whole)


@pytest.mark.parametrize("name", ["history.csv", "bests.bin"])
@pytest.mark.parametrize("keep", [0.0, 0.6, None])
def test_records_that_are_missing_are_one_message(half, name, keep):
    file = half.path / name
    if keep is None:
        file.unlink()
    else:
        file.write_bytes(file.read_bytes()[: int(file.stat().st_size * keep)])
    what = f"{name} is missing" if keep is None else f"{name} ends at generation [012]"
    asked = [lambda: RunWriter.open(half.path)]
    asked += (
        [half.fingerprint, lambda: half.history] if name == "history.csv" else [half.individual]
    )
    for ask in asked:
        with pytest.raises(RunError, match=f"{what}, but .* 4") as error:
            ask()
        assert error.value.where == str(file)
        assert "from one copy" in error.value.remedy


def spoil(path, how):
    if how == "missing":
        path.unlink()
    elif how == "truncated":
        path.write_bytes(path.read_bytes()[:-1])
    elif how == "foreign":
        path.write_bytes(b"\x80\x05cos\nsystem\n.")
    else:
        data = bytearray(path.read_bytes())
        data[100] ^= 1
        path.write_bytes(data)


@pytest.mark.parametrize("how", ["missing", "truncated", "changed", "foreign"])
def test_a_damaged_checkpoint_falls_back_to_the_same_end(half, whole, how):
    saved = read_checkpoint(half.path / "population.previous.pickle").generation
    spoil(half.path / "population.pickle", how)
    before = names(half.path)
    checkpoint, warning = half.checkpoint, half.warning
    assert checkpoint.generation == saved < 4
    assert f"population.previous.pickle of generation {saved} is used instead" in warning
    assert half.generation == len(half.history["best"]) == len(half.bests) == saved
    assert half.fingerprint()
    assert names(half.path) == before  # readers rename nothing
    assert f"of generation {saved} is used instead" in continue_run(half.path)
    kept = {name for name in names(half.path) if "damaged" in name}
    assert kept == (set() if how == "missing" else {"population.damaged-1.pickle"})
    assert_same(half, whole)


def edit(path, old, new):
    text = (path / "experiment.toml").read_text()
    assert old in text
    (path / "experiment.toml").write_text(text.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "allowed"),
    [
        ("population = 6", "population = 7", "a population of 7 with 3 genes of the kind 'real'"),
    ],
)
def test_an_experiment_edited_to_other_genomes_is_an_error(half, old, new, allowed):
    edit(half.path, old, new)
    run = RunSnapshot(half.path)
    for ask in (
        lambda: RunWriter.open(half.path, any_version=True),
        run.individual,
        lambda: run.bests,
    ):
        with pytest.raises(CheckpointError, match="population of 6 with 3 genes") as error:
            ask()
        assert error.value.where == str(half.path / "experiment.toml")
        assert allowed in error.value.allowed


def test_an_experiment_edited_otherwise_continues_with_a_warning(half, whole):
    edit(half.path, "price = 0.1", "price = 0.2")
    warning = continue_run(half.path)
    assert "experiment.toml was changed after generation 4 (fitness.price: 0.1, now 0.2)" in warning
    assert reopen(half).fingerprint() != whole.fingerprint()
    assert continue_run(half.path) == ""


def test_a_plugin_that_is_missing_is_named_with_its_package(half, monkeypatch):
    edit(half.path, 'plugin = "puppet-reach"', 'plugin = "gone-reach"')
    path = half.path / "population.pickle"
    checkpoint = half.checkpoint
    checkpoint.versions["fitness gone-reach"] = "gone 2.5"
    write_checkpoint(path, checkpoint)
    for ask in (lambda: RunWriter.open(half.path), lambda: RunSnapshot(half.path).experiment):
        with pytest.raises(ExperimentError, match="unknown fitness plugin 'gone-reach'") as error:
            ask()
        assert "pip install gone==2.5" in str(error.value)


def test_another_version_of_a_package_needs_any_version(half, whole):
    path = half.path / "population.pickle"
    checkpoint = half.checkpoint
    checkpoint.versions["organism puppet"] = "gaitsim-puppets 0.9"
    write_checkpoint(path, checkpoint)
    with pytest.raises(RunError, match="evolved with other versions of packages") as error:
        RunWriter.open(half.path)
    assert "organism puppet: gaitsim-puppets 0.9 then, gaitsim-puppets 1.0 now" in error.value.what
    assert "--any-version" in error.value.remedy
    assert continue_run(half.path, any_version=True) == ""
    assert_same(half, whole)
    assert continue_run(half.path) == ""


def test_one_writer_at_a_time(half):
    with RunWriter.open(half.path):
        with pytest.raises(RunError, match=f"is being written by process {os.getpid()} on"):
            RunWriter.open(half.path)
        assert half.fingerprint()  # reading needs no lock
    RunWriter.open(half.path).__exit__(None, None, None)


def test_a_writer_that_cannot_open_holds_no_lock(half, monkeypatch):
    descriptors = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0  # noqa: PTH112, PTH208
    asked = (half.path / "experiment.toml").read_bytes()
    (half.path / "bests.bin").write_bytes(b"")
    with pytest.raises(RunError):
        RunWriter.open(half.path, generations=50)
    assert (half.path / "experiment.toml").read_bytes() == asked
    shutil.rmtree(half.path / "champions")
    (half.path / "history.csv").unlink()
    with pytest.raises(RunError):
        RunWriter.open(half.path)
    if descriptors:
        assert len(os.listdir("/proc/self/fd")) == descriptors  # noqa: PTH208
