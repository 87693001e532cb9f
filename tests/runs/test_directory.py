import errno
import math
import os
import shutil
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from gaitsim.errors import CheckpointError, ExperimentError, PluginError, RunError
from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.runs.compatibility import versions
from gaitsim.runs.files import folder as folders
from gaitsim.runs.files.checkpoint import read_champion, read_checkpoint, write_checkpoint
from gaitsim.runs.files.folder import create_run, exports_folder, find_run, list_runs
from gaitsim.runs.files.history import best_terms
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.writer import RunWriter

LONG = "evolution.generations=8"
THRESHOLD = "evolution.fitness_threshold=0"


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, puppets):
    monkeypatch.chdir(tmp_path)


def events(writer):
    """The generations that follow in a run."""
    return evolve(
        writer.experiment, lambda genomes: evaluate(writer.experiment, genomes), writer.last
    )


def record_all(writer):
    for event in events(writer):
        writer.record(event)


def go_on(path, until=None, **options):
    """Evolve a run, at most to a generation; what its writer warned of."""
    with RunWriter.open(path, **options) as writer:
        for event in writer.evolve(lambda genomes: evaluate(writer.experiment, genomes)):
            if event.number == until:
                break
        return writer.warning


@pytest.fixture
def whole(puppet):
    """A run of eight generations that was never interrupted."""
    path = create_run(puppet(LONG, THRESHOLD), Path("whole"))
    go_on(path)
    return RunSnapshot(path)


@pytest.fixture
def half(puppet):
    """The same run, stopped after generation 4."""
    path = create_run(puppet(LONG, THRESHOLD), Path("half"))
    go_on(path, 4)
    return RunSnapshot(path)


def again(run):
    """The same run as it is now."""
    return RunSnapshot(run.path)


def assert_same(one, other):
    """Two runs hold the same, but for the times in their histories."""
    one, other = again(one), again(other)
    assert one.fingerprint() == other.fingerprint()
    assert (one.path / "bests.bin").read_bytes() == (other.path / "bests.bin").read_bytes()
    champions = [sorted((run.path / "champions").iterdir()) for run in (one, other)]
    assert [path.name for path in champions[0]] == [path.name for path in champions[1]]
    for a, b in zip(*champions, strict=True):
        assert a.read_bytes() == b.read_bytes()
    assert one.generation == other.generation


def names(path):
    return {item.name for item in path.iterdir()}


# Making, finding and listing


def test_a_new_run_holds_its_experiment_and_empty_folders(puppet):
    path = create_run(puppet())
    assert path == Path("runs/puppet")
    assert names(path) == {"experiment.toml", "champions", "exports"}
    assert RunSnapshot(path).experiment == puppet()
    assert names(Path("runs")) == {"puppet"}


def test_a_name_that_is_taken_gets_a_number(puppet):
    assert [create_run(puppet()).name for _ in range(3)] == ["puppet", "puppet-2", "puppet-3"]
    out = Path("new/deep/out")
    assert create_run(puppet(), out) == out
    assert create_run(puppet(), out) == Path("new/deep/out-2")
    Path("file").touch()
    assert create_run(puppet(), Path("file")) == Path("file-2")
    Path("link").symlink_to("nowhere")
    assert create_run(puppet(), Path("link")) == Path("link-2")
    assert Path("file").read_bytes() == b""


def test_runs_that_begin_at_once_get_a_folder_each(puppet):
    with ThreadPoolExecutor(8) as pool:
        paths = list(pool.map(create_run, [puppet() for _ in range(16)]))
    assert len(set(paths)) == 16
    assert names(Path("runs")) == {path.name for path in paths}


def test_a_name_taken_in_the_last_moment_is_not_overwritten(puppet, monkeypatch):
    real, seen = os.path.lexists, []

    def late(path):
        seen.append(path)
        return False if len(seen) == 1 else real(path)

    first = create_run(puppet())
    monkeypatch.setattr(os.path, "lexists", late)
    assert create_run(puppet()) == Path("runs/puppet-2")
    assert names(first) == {"experiment.toml", "champions", "exports"}


@pytest.mark.parametrize("out", [".", "..", "/", "a/.."])
def test_a_folder_that_cannot_be_made_is_refused(puppet, out):
    before = names(Path("..").resolve())
    with pytest.raises(RunError, match="is there already"):
        create_run(puppet(), Path(out))
    assert names(Path()) == set()
    assert names(Path("..").resolve()) == before


def test_a_file_for_a_folder_is_one_message(puppet):
    Path("file").touch()
    with pytest.raises(RunError, match=r"run cannot be written: (Not a directory|File exists)"):
        create_run(puppet(), Path("file/run"))
    Path("runs").touch()
    with pytest.raises(RunError, match="puppet cannot be written"):
        create_run(puppet())


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS])
@pytest.mark.parametrize("number", range(6))
def test_a_run_that_cannot_be_made_leaves_nothing(puppet, monkeypatch, number, code):
    steps = iter(range(100))

    def failing(real):
        def stub(*arguments, **options):
            if next(steps) == number:
                raise OSError(code, os.strerror(code))
            return real(*arguments, **options)

        return stub

    Path("runs").mkdir()
    for owner, name in [(os, "fsync"), (Path, "mkdir"), (Path, "replace"), (Path, "rename")]:
        monkeypatch.setattr(owner, name, failing(getattr(owner, name)))
    with pytest.raises(RunError, match=os.strerror(code)) as error:
        create_run(puppet())
    assert error.value.remedy
    assert names(Path("runs")) == set()


def test_drafts_of_killed_programs_are_removed_after_an_hour(puppet):
    for name, age in [("runs/.new-run-old", 3700), ("runs/.new-run-fresh", 60)]:
        (Path(name) / "champions").mkdir(parents=True)
        made = time.time() - age
        os.utime(name, (made, made))
    create_run(puppet())
    assert names(Path("runs")) == {".new-run-fresh", "puppet"}


def test_a_population_too_large_for_a_checkpoint_is_refused(puppet, monkeypatch):
    monkeypatch.setattr(folders, "MAX_BYTES", 1000)
    create_run(puppet("evolution.population=20"))
    with pytest.raises(RunError, match="21 individuals with 3 genes are too many") as error:
        create_run(puppet("evolution.population=21"))
    assert error.value.allowed == "evolution.population up to 20"


def test_a_run_is_found_by_name_and_by_path(puppet):
    path = create_run(puppet())
    assert find_run("puppet") == find_run("runs/puppet") == path
    assert find_run(str(path.resolve())) == path.resolve()
    assert find_run("runs/puppet/") == path


@pytest.mark.parametrize("name", ["nobody", "", "a" * 300, "a\0b", "runs/puppet/experiment.toml"])
def test_what_is_no_run_is_not_found(puppet, name):
    with pytest.raises(RunError, match="there is no run") as error:
        find_run(name)
    assert error.value.allowed == "no run is in runs/ of this folder yet"
    create_run(puppet())
    with pytest.raises(RunError, match="there is no run") as error:
        find_run(name)
    assert error.value.allowed == "puppet"


def test_a_folder_without_an_experiment_is_no_run():
    Path("runs/empty").mkdir(parents=True)
    for name in ("empty", "runs/empty"):
        with pytest.raises(RunError, match="is not a run: it holds no"):
            find_run(name)


def test_a_run_without_its_experiment_is_told_from_a_folder(whole):
    (whole.path / "experiment.toml").unlink()
    with pytest.raises(RunError, match=r"the run whole has lost its experiment\.toml"):
        find_run("whole")


def test_runs_are_listed_oldest_first(puppet):
    assert list_runs(Path("runs")) == []
    paths = [create_run(puppet()) for _ in range(3)]
    for age, path in zip([5, 9, 5], paths, strict=True):
        os.utime(path / "experiment.toml", (1e9 - age, 1e9 - age))
    Path("runs/file").touch()
    Path("runs/other").mkdir()
    Path("runs/broken").symlink_to("nowhere")
    shutil.copytree(paths[0], "runs/.new-run-1234")  # left by a killed program
    assert [path.name for path in list_runs(Path("runs"))] == ["puppet-2", "puppet", "puppet-3"]
    with pytest.raises(RunError, match="cannot list runs/file"):
        list_runs(Path("runs/file"))


def test_commands_are_what_a_shell_takes():
    assert folders.command("resume", Path("my runs/a"), 3) == "gaitsim resume 'my runs/a' 3"


# Writing and reading


def test_a_run_is_written_and_read(whole, puppet):
    assert names(whole.path) - {".lock", ".lock-owner"} == {
        "experiment.toml",
        "history.csv",
        "bests.bin",
        "checksums.bin",
        "provenance.json",
        "population.pickle",
        "population.previous.pickle",
        "champions",
        "exports",
    }
    checkpoint, warning = whole.checkpoint, whole.warning
    assert not warning
    assert (checkpoint.generation, checkpoint.evaluations) == (8, 48)
    assert checkpoint.experiment == puppet(LONG, THRESHOLD).to_toml()
    assert checkpoint.versions == versions(puppet())
    assert checkpoint.versions["organism puppet"] == "gaitsim-puppets 1.0"
    history, bests = whole.history, whole.bests
    assert history["generation"].tolist() == list(range(1, 9))
    assert np.array_equal(bests["score"], history["best"])
    for generation in (1, 5, 8):
        best = whole.individual(generation)
        number, score, genome = best.generation, best.score, best.genome
        evaluation = evaluate(puppet(), genome[None])
        assert (number, score) == (generation, evaluation.scores[0])
        assert best_terms(whole.history, generation) == {
            n: v[0] for n, v in evaluation.terms.items()
        }
        assert genome.flags.writeable
    assert whole.individual().generation == int(np.argmax(bests["score"])) + 1


def test_a_run_whose_checkpoints_are_gone_does_not_begin_anew(whole):
    for name in ("population.pickle", "population.previous.pickle"):
        (whole.path / name).unlink()
    before = (whole.path / "history.csv").read_bytes()
    with pytest.raises(CheckpointError, match=r"are gone, but history\.csv holds generations"):
        RunSnapshot(whole.path).generation  # noqa: B018
    with pytest.raises(CheckpointError):
        go_on(whole.path)
    assert (whole.path / "history.csv").read_bytes() == before
    # One row may have been written before its checkpoint, which was not.
    (whole.path / "history.csv").write_bytes(b"\n".join(before.split(b"\n")[:2]) + b"\n")
    assert RunSnapshot(whole.path).generation == 0


def test_a_best_that_the_history_does_not_know_is_refused(whole):
    path = whole.path / "bests.bin"
    path.write_bytes(np.random.default_rng(0).bytes(path.stat().st_size))
    with pytest.raises(RunError, match=r"in bests\.bin, but .* in history\.csv"):
        RunSnapshot(whole.path).individual()


def test_champions_are_kept_each_time_the_best_beats_the_threshold(whole):
    files = sorted((whole.path / "champions").iterdir())
    threshold, expected = 0.0, []
    for number, best in enumerate(whole.history["best"], start=1):
        if best > threshold:
            expected.append(f"generation-{number:06d}.pickle")
            threshold += 0.1 * math.ceil((best - threshold) / 0.1)
    assert [file.name for file in files] == expected
    assert 1 < len(files) < 8
    for file in files:
        champion = read_champion(file)
        best = whole.individual(champion.generation)
        score, genome = best.score, best.genome
        assert champion.score == score
        assert champion.genome.tobytes() == genome.tobytes()
        assert champion.terms == best_terms(whole.history, champion.generation)


@pytest.mark.parametrize("until", [1, 2, 4, 7, 8])
def test_a_run_gone_on_with_is_the_same(whole, puppet, until):
    path = create_run(puppet(LONG, THRESHOLD))
    go_on(path, until)
    assert go_on(path) == ""
    assert_same(RunSnapshot(path), whole)


@pytest.mark.parametrize(
    "stop", ["stagnation=2", "target_score=2.4", "max_evaluations=40", "stagnation=3"]
)
def test_a_run_gone_on_with_stops_where_it_would_have(puppet, stop):
    overrides = ("evolution.generations=60", f"evolution.{stop}")
    whole = create_run(puppet(*overrides))
    go_on(whole)
    end = RunSnapshot(whole).generation
    assert 3 < end < 60
    path = create_run(puppet(*overrides))
    for generation in range(1, end + 2):
        go_on(path, generation)
    assert RunSnapshot(path).generation == end
    assert RunSnapshot(path).fingerprint() == RunSnapshot(whole).fingerprint()


def test_a_run_extended_is_the_same(whole, puppet):
    path = create_run(puppet(THRESHOLD, "evolution.generations=3"))
    go_on(path)
    assert RunSnapshot(path).generation == 3
    assert go_on(path, generations=8) == ""
    assert RunSnapshot(path).fingerprint() == whole.fingerprint()
    assert RunSnapshot(path).experiment.evolution.generations == 8
    with pytest.raises(RunError, match="is at generation 8 already") as error:
        RunWriter.open(path, generations=7)
    assert error.value.allowed == "--generations 8 or more"
    assert RunSnapshot(path).experiment.evolution.generations == 8


def test_a_run_grows_while_it_is_read(half, whole):
    assert (half.generation, len(half.history["best"]), len(half.bests)) == (4, 4, 4)
    go_on(half.path)
    assert (half.generation, len(half.history["best"]), len(half.bests)) == (4, 4, 4)
    grown = again(half)
    assert (grown.generation, len(grown.history["best"]), len(grown.bests)) == (8, 8, 8)


def test_before_the_first_generation_there_is_nothing(puppet):
    run = RunSnapshot(create_run(puppet()))
    assert run.checkpoint is None
    assert (run.generation, run.history, len(run.bests)) == (0, {}, 0)
    for ask in (run.individual, run.fingerprint, lambda: run.individual(1)):
        with pytest.raises(RunError, match="has no finished generation yet") as error:
            ask()
        assert "gaitsim resume runs/puppet" in error.value.remedy


def test_a_generation_that_is_not_there_is_refused(half):
    for number in (0, -1, 5):
        with pytest.raises(RunError, match=f"has no generation {number}") as error:
            half.individual(number)
        assert error.value.allowed == "1 to 4"


class Killed(BaseException):
    """As if the process were gone."""


# What is written of a generation, in its order.
STEPS = [
    (os, "write", 0),
    (os, "write", 1),
    (os, "fsync", 0),
    (os, "fsync", 1),
    (os, "fsync", 2),
    (Path, "replace", 0),
    (Path, "replace", 1),
    (os, "fsync", 3),
]


@pytest.mark.parametrize(("owner", "step", "number"), STEPS)
@pytest.mark.parametrize("begun", [0, 3])
def test_a_run_killed_at_any_step_goes_on_the_same(
    whole, puppet, monkeypatch, begun, owner, step, number
):
    path = create_run(puppet(LONG, "evolution.fitness_threshold=0"))
    if begun:
        go_on(path, begun)
    before = begun and RunSnapshot(path).fingerprint()
    real, calls = getattr(owner, step), iter(range(100))

    def stub(*arguments, **options):
        if next(calls) == number:
            if step == "write":
                real(arguments[0], arguments[1][:9])
            raise Killed
        return real(*arguments, **options)

    with RunWriter.open(path) as writer, monkeypatch.context() as patch:
        event = next(events(writer))
        patch.setattr(owner, step, stub)
        with pytest.raises(Killed):
            writer.record(event)
    # Until the new checkpoint is there, the run is what it was, and is read as such.
    run = RunSnapshot(path)
    if run.generation == begun:
        assert len(run.history.get("best", [])) == begun
        assert len(run.bests) == begun
        assert (begun and run.fingerprint()) == before
    go_on(path)
    assert_same(run, whole)
    assert not [name for name in names(path) if name.endswith(".partial")]


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
    read = again(half)
    assert read.fingerprint() == fingerprint
    assert len(read.history["best"]) == len(read.bests) == 4
    with RunWriter.open(half.path):
        pass
    assert len((half.path / "history.csv").read_text().splitlines()) == 5
    assert (half.path / "bests.bin").stat().st_size == 4 * 32
    assert "generation-000005.pickle" not in names(half.path / "champions")
    (half.path / "champions/generation-mine.pickle").unlink()
    go_on(half.path)
    assert_same(half, whole)


@pytest.mark.parametrize("name", ["history.csv", "bests.bin"])
@pytest.mark.parametrize("keep", [0.0, 0.6, None])
def test_records_that_are_missing_are_one_message(half, name, keep):
    file = half.path / name
    if keep is None:
        file.unlink()
    else:
        file.write_bytes(file.read_bytes()[: int(file.stat().st_size * keep)])
    what = f"there is no {name}" if keep is None else f"{name} ends at generation [012]"
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
    spoil(half.path / "population.pickle", how)
    before = names(half.path)
    checkpoint, warning = half.checkpoint, half.warning
    assert checkpoint.generation == 3
    assert "population.previous.pickle, of generation 3, is used instead" in warning
    assert half.generation == len(half.history["best"]) == len(half.bests) == 3
    assert half.fingerprint()
    assert names(half.path) == before  # who only reads renames nothing
    assert "of generation 3, is used instead" in go_on(half.path)
    kept = {name for name in names(half.path) if "damaged" in name}
    assert kept == (set() if how == "missing" else {"population.damaged-1.pickle"})
    assert_same(half, whole)


def test_two_damaged_checkpoints_are_one_message(half):
    for name in ("population.pickle", "population.previous.pickle"):
        spoil(half.path / name, "changed")
    before = names(half.path)
    for ask in (lambda: half.checkpoint, half.fingerprint, lambda: RunWriter.open(half.path)):
        with pytest.raises(CheckpointError, match="neither checkpoint can be read"):
            ask()
    assert names(half.path) == before


def edit(path, old, new):
    text = (path / "experiment.toml").read_text()
    assert old in text
    (path / "experiment.toml").write_text(text.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "allowed"),
    [
        ("population = 6", "population = 7", "a population of 7 with 3 real genes"),
        ('plugin = "puppet"', 'plugin = "bit-puppet"', "a population of 6 with 3 bit genes"),
        ('plugin = "puppet"', 'plugin = "wide-puppet"', "a population of 6 with 4 real genes"),
    ],
)
def test_an_experiment_edited_to_other_genomes_is_refused(
    half, monkeypatch, puppets, install, old, new, allowed
):
    install(
        "wide",
        "import numpy as np\nfrom gaitsim_puppets import Puppet\n"
        "from gaitsim.contracts import RealSpace\n"
        "class Wide(Puppet):\n"
        "    def genome_space(self):\n"
        "        return RealSpace(np.zeros(4), np.ones(4), tuple('abcd'))\n",
        {"organism": {"wide-puppet": "Wide"}},
    )
    edit(half.path, old, new)
    run = RunSnapshot(half.path)
    for ask in (
        lambda: RunWriter.open(half.path, any_version=True),
        run.individual,
        lambda: run.bests,
    ):
        with pytest.raises(
            CheckpointError, match=r"population of 6 with 3 genes in .* not"
        ) as error:
            ask()
        assert error.value.where == str(half.path / "experiment.toml")
        assert allowed in error.value.allowed


def test_an_experiment_edited_otherwise_goes_on_with_a_warning(half, whole):
    edit(half.path, "price = 0.1", "price = 0.2")
    warning = go_on(half.path)
    assert "experiment.toml was changed after generation 4 (fitness.price: 0.1, now 0.2)" in warning
    assert again(half).fingerprint() != whole.fingerprint()
    assert go_on(half.path) == ""


@pytest.mark.parametrize("text", [b"\xff\xfe", None])
def test_an_experiment_that_cannot_be_read_is_one_message(half, text):
    (half.path / "experiment.toml").unlink()
    if text:
        (half.path / "experiment.toml").write_bytes(text)
    with pytest.raises(RunError, match=r"cannot read .*experiment\.toml: "):
        RunWriter.open(half.path)


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


def test_another_version_of_a_package_is_refused_unless_wanted(half, whole):
    path = half.path / "population.pickle"
    checkpoint = half.checkpoint
    checkpoint.versions["organism puppet"] = "gaitsim-puppets 0.9"
    write_checkpoint(path, checkpoint)
    with pytest.raises(RunError, match="made with other versions") as error:
        RunWriter.open(half.path)
    assert "organism puppet: gaitsim-puppets 0.9 then, gaitsim-puppets 1.0 now" in error.value.what
    assert "--any-version" in error.value.remedy
    assert go_on(half.path, any_version=True) == ""
    assert_same(half, whole)
    assert go_on(half.path) == ""


def test_another_numpy_is_a_warning(half):
    path = half.path / "population.pickle"
    checkpoint = half.checkpoint
    checkpoint.versions["numpy"] = "1.0"
    write_checkpoint(path, checkpoint)
    assert "another version of numpy: 1.0 then" in go_on(half.path)


def test_one_writer_at_a_time(half):
    with RunWriter.open(half.path):
        with pytest.raises(RunError, match=f"is being written by process {os.getpid()} on"):
            RunWriter.open(half.path)
        assert half.fingerprint()  # reading is free
    RunWriter.open(half.path).__exit__(None, None, None)


def test_a_writer_that_cannot_begin_holds_nothing(half, monkeypatch):
    descriptors = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0  # noqa: PTH112, PTH208
    (half.path / "bests.bin").write_bytes(b"")
    with pytest.raises(RunError):
        RunWriter.open(half.path)
    shutil.rmtree(half.path / "champions")
    (half.path / "history.csv").unlink()
    with pytest.raises(RunError):
        RunWriter.open(half.path)
    if descriptors:
        assert len(os.listdir("/proc/self/fd")) == descriptors  # noqa: PTH208


@pytest.mark.parametrize("step", ["write", "fsync"])
@pytest.mark.parametrize("number", range(4))
def test_a_full_disk_stops_the_run_as_it_was(half, whole, monkeypatch, step, number):
    fingerprint = half.fingerprint()
    calls, real = iter(range(100)), getattr(os, step)

    def full(*arguments):
        if next(calls) >= number:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(*arguments)

    with monkeypatch.context() as patch, RunWriter.open(half.path) as writer:
        patch.setattr(os, step, full)
        with pytest.raises(RunError, match="No space left") as error:
            record_all(writer)
        assert "free some space" in error.value.remedy
        stopped = read_checkpoint(half.path / "population.pickle").generation
    assert stopped > 4 or again(half).fingerprint() == fingerprint
    go_on(half.path)
    assert_same(half, whole)


def test_a_folder_that_is_gone_is_said(half):
    with RunWriter.open(half.path) as writer:
        event = next(events(writer))
        shutil.rmtree(half.path)
        with pytest.raises(RunError, match="the folder of the run half is gone"):
            writer.record(event)
    assert not half.path.exists()


def test_folders_that_a_user_removed_are_made_again(half, whole):
    shutil.rmtree(half.path / "champions")
    shutil.rmtree(half.path / "exports")
    go_on(half.path)
    assert exports_folder(half.path).is_dir()


@pytest.mark.parametrize(
    "terms",
    [("best", "reach"), ("seconds",), ("reach", "mean:reach")],
)
def test_terms_named_as_columns_are_refused(puppet, puppets, monkeypatch, terms):
    monkeypatch.setattr(
        puppets.Reach, "terms", lambda self, motion: dict.fromkeys(terms, motion["reach"])
    )
    path = create_run(puppet())
    with pytest.raises(PluginError, match=r"fitness 'puppet-reach' of package gaitsim-puppets"):
        go_on(path)
    assert RunSnapshot(path).generation == 0


def test_a_run_in_which_all_fail_is_written_and_gone_on_with(puppet, puppets, monkeypatch):
    monkeypatch.setattr(
        puppets.Reach, "terms", lambda self, motion: {"reach": motion["reach"] * np.nan}
    )
    path = create_run(puppet("evolution.population=1002"))
    go_on(path, 2)
    assert go_on(path) == ""
    run = RunSnapshot(path)
    assert run.generation == 5
    assert (run.history["best"] == -np.inf).all()
    reasons = run.checkpoint.reasons
    assert len(reasons) == 1000  # of the rest it is as well known
    assert set(reasons.values()) == {"reach is nan"}
    for generation in (None, 2):
        with pytest.raises(RunError, match=r"has no champion: every individual of .* failed"):
            run.individual(generation)
    assert run.fingerprint()


def test_bits_are_written_and_read(puppet):
    path = create_run(puppet("organism.plugin=bit-puppet"))
    go_on(path, 2)
    go_on(path)
    best = RunSnapshot(path).individual()
    score, genome = best.score, best.genome
    assert genome.dtype == np.uint8
    assert evaluate(RunSnapshot(path).experiment, genome[None]).scores[0] == score


def test_a_fingerprint_is_of_all_but_time(whole, puppet):
    other = create_run(puppet(LONG, THRESHOLD), Path("other"))
    go_on(other)
    assert (other / "history.csv").read_text() != (whole.path / "history.csv").read_text()
    assert RunSnapshot(other).fingerprint() == whole.fingerprint()
    text = (other / "history.csv").read_text()
    row = text.splitlines()[3].split(",")
    (other / "history.csv").write_text(text.replace(row[3], repr(math.nextafter(float(row[3]), 9))))
    assert RunSnapshot(other).fingerprint() != whole.fingerprint()
    another = create_run(puppet(LONG, "seed=2"))
    go_on(another)
    assert RunSnapshot(another).fingerprint() != whole.fingerprint()
