"""Runs that start from a saved individual."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from run_helpers import THRESHOLD, evolve_run

from gaitsim.errors import CheckpointError, ExperimentError, RunError
from gaitsim.evaluation import evaluate
from gaitsim.evaluation.streams import Purpose, stream
from gaitsim.storage.compatibility import check_start
from gaitsim.storage.creation import create_run, find_individual
from gaitsim.storage.files.checkpoint import Champion, Start, read_champion
from gaitsim.storage.files.folder import START
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, climb):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def staged(puppet, once):
    """A run of two stages, each of which saved champions."""

    def create():
        run = evolve_run(create_run(puppet(THRESHOLD), Path("staged")))
        evolve_run(run.path, None, "fitness.plugin=puppet-climb", generations=10)

    return RunSnapshot(once("two stages", Path("staged"), create))


def test_an_individual_is_named_by_file_run_and_generation(staged):
    best = staged.individual()
    number, score, genome = best.generation, best.score, best.genome
    assert number > 5
    for reference in ("staged", f"staged@{number}", str(staged.path.resolve())):
        kept = find_individual(reference)
        assert (kept.generation, kept.score) == (number, score)
        assert kept.genome.tobytes() == genome.tobytes()
        assert kept.experiment == staged.stages[1].experiment
    early = find_individual("staged@2")
    assert early.experiment == staged.stages[0].experiment
    assert early.versions == staged.stages[0].versions
    assert set(early.terms) == {"reach", "price"}
    file = sorted((staged.path / "champions").iterdir())[0]
    assert find_individual(str(file)).experiment == early.experiment


def test_a_run_whose_name_ends_as_a_generation_is_named_first(puppet):
    one = evolve_run(create_run(puppet(), Path("runs/a")))
    other = evolve_run(create_run(puppet("seed=2"), Path("runs/a@2")))
    assert find_individual("a@2").score == other.individual().score
    assert find_individual("a@3").score == one.individual(3).score
    assert find_individual("a@2@1").score == other.individual(1).score


@pytest.mark.parametrize(
    ("reference", "says"),
    [
        ("nobody", "there is no run 'nobody'"),
        ("staged@11", "has no generation 11"),
        ("staged#1", "has no members"),
        ("staged@x", "there is no run 'staged@x'"),
        ("a\0b", "there is no run"),
        ("staged/population.pickle", "is not a valid champion"),
        ("staged/experiment.toml", "cannot read experiment.toml as a checkpoint"),
        ("/dev/zero", "it is not a regular file"),
    ],
)
def test_invalid_references_to_individuals_are_errors(staged, reference, says):
    with pytest.raises(RunError, match=says):
        find_individual(reference)


def test_the_first_population_begins_at_the_individual_and_its_mutants(puppet, staged):
    start = find_individual("staged@2")
    experiment = puppet("seed=5", "search.start_share=0.5")
    run = evolve_run(create_run(experiment, Path("from"), start), 1)
    genomes = run.checkpoint.genomes
    assert genomes[0].tobytes() == start.genome.tobytes()
    copies = np.tile(start.genome, (2, 1))
    noise = stream(5, 1, Purpose.MUTATION)
    mutants = experiment.mutation.mutate(copies, experiment.space(), noise)
    assert np.array_equal(genomes[1:3], experiment.space().repair(mutants))
    assert len(np.unique(genomes, axis=0)) == 6
    assert run.individual(1).score >= evaluate(experiment, start.genome[None]).scores[0]


def test_a_run_from_each_saved_champion_is_reproducible(puppet, staged):
    files = sorted((staged.path / "champions").iterdir())
    assert {staged.stage_at(read_champion(file).generation).number for file in files} == {1, 2}
    found = set()
    for file in files:
        start = find_individual(str(file))
        whole = evolve_run(create_run(puppet(), Path("whole"), start))
        parts = create_run(puppet(), Path("parts"), start)
        for until in (1, 3, None):
            evolve_run(parts, until)
        assert RunSnapshot(parts).fingerprint() == whole.fingerprint()
        assert (parts / "bests.bin").read_bytes() == (whole.path / "bests.bin").read_bytes()
        found.add(whole.fingerprint())
    assert len(found) == len(files)


def test_a_run_needs_nothing_but_its_own_folder(puppet, staged):
    path = create_run(puppet(), Path("from"), find_individual("staged"))
    shutil.copytree(path, "copy")
    whole = evolve_run(path)
    shutil.rmtree(staged.path)
    assert evolve_run(Path("copy")).fingerprint() == whole.fingerprint()
    assert whole.start.generation == RunSnapshot(Path("copy")).start.generation
    unlike = evolve_run(create_run(puppet(), Path("unlike")))
    assert unlike.fingerprint() != whole.fingerprint()
    assert unlike.start is None


def test_the_start_is_checked_against_the_body_when_the_run_starts(puppet, staged):
    start = find_individual("staged")
    path = create_run(puppet(), Path("from"), start)
    with pytest.raises(
        RunError, match="the genome has 3 genes of the kind 'real' of the body 'puppet'"
    ):
        RunWriter.open(path, overrides={"organism.plugin": "bit-puppet"})
    assert "bit-puppet" not in (path / "experiment.toml").read_text()
    with pytest.raises(ExperimentError):
        RunWriter.open(path, overrides={"organism.plugin": "none"})
    (path / START).write_bytes((path / START).read_bytes()[:-1])
    with pytest.raises(CheckpointError, match=r"start\.pickle") as error:
        RunWriter.open(path)
    assert "restore it from a copy" in error.value.remedy
    assert RunSnapshot(path).generation == 0


def champion(experiment, genome):
    return Champion(experiment.to_toml(), {}, 7, np.array(genome), 1.0, {})


MISFITS = {
    "length": (
        "organism.names=abcd",
        [0.0] * 4,
        "has 4 genes of the kind 'real' of the body 'shaped'",
    ),
    "labels": ("organism.names=abd", [0.0] * 3, "gene 3 is 'd', not 'c'"),
    "bounds": ("organism.most=5", [0.0, 0.0, 4.0], "'c' is 4, allowed -1 to 2"),
}


@pytest.mark.parametrize(("option", "genome", "says"), MISFITS.values(), ids=MISFITS.keys())
def test_a_genome_of_another_body_is_an_error(puppet, option, genome, says):
    shaped = ("organism.plugin=shaped",)
    came = champion(puppet(*shaped, option), genome)
    with pytest.raises(RunError) as error:
        check_start(puppet(*shaped), Start.of(came), "--from file")
    assert says in error.value.what
    assert error.value.where == "--from file"
    assert error.value.allowed.startswith("3 genes of the kind 'real' of the body 'shaped'")
    fitting = champion(puppet(*shaped), [0.0, 1.0, 2.0])
    check_start(puppet(*shaped), Start.of(fitting), "")
