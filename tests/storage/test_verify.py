"""Any change of a run is found, and its file and generation named."""

import json
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from run_helpers import evolve_run

from gaitsim.errors import RunError
from gaitsim.evaluation import evaluate
from gaitsim.experiment import parse_assignments, with_overrides
from gaitsim.storage.creation import champion_of, create_run, fork_run
from gaitsim.storage.files.checkpoint import pack, read_checkpoint
from gaitsim.storage.files.history import row
from gaitsim.storage.files.records import RECORD, SIZE, genomes_checksum, scores_checksum
from gaitsim.storage.provenance import read_provenance, write_provenance
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import restore_generation
from gaitsim.storage.verification import expected_chain, verify_run

LAST = 12


def verify(run, *, everything=False):
    """Verify a run as it is now; by default a part of it, as of a run that took long."""
    return verify_run(RunSnapshot(run.path), everything=everything, workers=1)


def generations(verdict):
    return [*dict.fromkeys(one.generation for one in verdict.differences)]


@pytest.fixture
def run(puppet, tmp_path, gathering, once):
    """A run of three stages, the second with a different fitness; it was also stopped once."""
    path = tmp_path / "run"

    def create():
        create_run(puppet("evolution.generations=4", "evolution.fitness_threshold=0"), path)
        evolve_run(path, 2)
        evolve_run(path)
        evolve_run(path, None, "fitness.price=0.4", generations=8)
        evolve_run(path, None, "search.elites=1", generations=LAST)

    return RunSnapshot(once("three stages", path, create))


def test_a_run_of_stages_is_identical(run):
    verdict = verify(run, everything=True)
    assert verdict.identical, verdict.differences
    assert (verdict.again, verdict.complete) == (tuple(range(1, LAST + 1)), True)
    assert (verdict.notes, verdict.version_differences) == ((), ())
    assert [origin.first for origin in verdict.origins] == [1]
    assert {one.file for one in verdict.files if one.result != "same"} == {"provenance.json"}
    some = verify(run)
    assert some.identical, some.differences
    assert (some.again, some.complete) == ((), False)
    unknown = {one.file for one in some.files if one.result == "cannot be known"}
    assert unknown >= {"history.csv", "population.pickle", "checksums.bin"}
    assert verify(run, everything=None).complete  # a quick run


def test_forks_and_runs_from_an_individual_are_identical(run, puppet, tmp_path):
    fork = RunSnapshot(fork_run(run.path, overrides={"mutation.plugin": "puppet-jitter"}))
    assert verify(fork).identical
    evolve_run(fork.path, generations=LAST + 2)
    assert verify(fork, everything=True).identical
    begun = create_run(puppet(), tmp_path / "begun", champion_of(run, 3))
    assert verify(evolve_run(begun), everything=True).identical


def digested(run, generation, **parts):
    """Recompute digests, as a forger would."""
    path = run.path / "checksums.bin"
    records = np.frombuffer(path.read_bytes(), RECORD).copy()
    for part, digest in parts.items():
        records[part][generation - 1] = np.void(digest)
    path.write_bytes(records.tobytes())


def refit(run, generation):
    """Recompute the checksum chain from the files, from a generation on."""
    for number in range(generation, LAST + 1):
        run = RunSnapshot(run.path)
        digested(run, number, chain=expected_chain(run, number))


def forge_bests(run, generation, change):
    path = run.path / "bests.bin"
    records = run.bests.copy()
    change(records[generation - 1])
    path.write_bytes(records.tobytes())


def forge_history(run, generation, column, value):
    path = run.path / "history.csv"
    lines = path.read_text().splitlines()
    cells = lines[generation].split(",")
    cells[lines[0].split(",").index(column)] = repr(value)
    lines[generation] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")


def forge_checkpoint(run, name="population.pickle", **changes):
    path = run.path / name
    checkpoint = replace(read_checkpoint(path), **changes)
    path.write_bytes(pack(checkpoint))
    return checkpoint


@pytest.mark.parametrize("generation", [1, 6, LAST])
def test_one_gene_of_a_best_is_found(run, generation):
    def change(record):
        record["genome"][2] += 1e-9

    forge_bests(run, generation, change)
    assert generations(verify(run))[0] == generation
    refit(run, generation)
    # The digest matches, but moving the individual reveals the change, as does evolving the run.
    assert generations(verify(run)) == [generation]
    assert generations(verify(run, everything=True))[0] == generation


@pytest.mark.parametrize(("column", "value"), [("mean", 0.5), ("diversity", 0.1)])
def test_one_number_of_the_history_is_found(run, column, value):
    forge_history(run, 7, column, value)
    (found,) = verify(run).differences[:1]
    assert (found.file, found.generation) == ("checksums.bin", 7)
    refit(run, 7)
    verdict = verify(run, everything=True)
    assert generations(verdict) == [7]
    assert str(verdict.differences[0]).startswith(
        f"generation 7: history.csv: {column} is {value}, but "
    )
    assert verdict.again == tuple(range(1, 8))  # up to the first difference
    assert {one.file for one in verdict.files if one.result == "differs"} == {"history.csv"}


def test_one_gene_of_the_checkpoint_is_found(run):
    genomes = run.checkpoint.genomes.copy()
    genomes[3, 1] += 1e-9
    forged = forge_checkpoint(run, genomes=genomes)
    assert "the genomes do not match checksums.bin" in str(verify(run).differences[0])
    # A forger may adapt digests, scores and the row; evolving the generation again reveals it.
    evaluation = evaluate(run.experiment, forged.genomes)
    forge_checkpoint(run, scores=evaluation.scores, terms=evaluation.terms)
    digested(
        run, LAST, genomes=genomes_checksum(forged.genomes), scores=scores_checksum(evaluation)
    )
    generation = restore_generation(read_checkpoint(run.path / "population.pickle"))
    space = run.experiment.space()
    generation = replace(generation, diversity=float(space.diversity(forged.genomes)))
    for column, value in row(generation).items():
        if column not in ("seconds", "generation", "stage", "evaluations"):
            forge_history(run, LAST, column, value)
    refit(run, LAST)
    assert generations(verify(run, everything=True)) == [LAST]


def cut(data):
    return data[:50]


def flipped(data):
    return data[:-9] + bytes([data[-9] ^ 1]) + data[-8:]


@pytest.mark.parametrize("spoilt", [cut, flipped])
@pytest.mark.parametrize("name", ["population.pickle", "population.previous.pickle"])
def test_a_damaged_checkpoint_is_a_difference(run, name, spoilt):
    path, before = run.path / name, run.previous.generation
    path.write_bytes(spoilt(path.read_bytes()))
    for everything in (True, False):
        verdict = verify(run, everything=everything)
        (found,) = verdict.differences  # the remaining files are compared
        assert found.file == name
        assert found.what.startswith(f"cannot read {name} as a checkpoint: it is ")
        assert verdict.total == (before if name == "population.pickle" else LAST)


def test_a_missing_checkpoint_is_a_difference_unless_it_is_the_previous_one(run):
    (run.path / "population.previous.pickle").rename(run.path / "kept")
    assert verify(run, everything=True).identical
    (run.path / "kept").rename(run.path / "population.previous.pickle")
    (run.path / "population.pickle").unlink()
    (found,) = verify(run, everything=True).differences
    assert "cannot read population.pickle as a checkpoint: file not found" in found.what


@pytest.mark.parametrize("generation", [1, LAST])
@pytest.mark.parametrize("at", [0, SIZE, 2 * SIZE])
def test_each_checksum_that_was_changed_is_found(run, generation, at):
    path = run.path / "checksums.bin"
    data = bytearray(path.read_bytes())
    data[(generation - 1) * RECORD.itemsize + at + 7] ^= 1
    path.write_bytes(data)
    assert generations(verify(run))[0] == generation


def test_checksums_set_to_zero_are_found_even_with_a_new_chain(run):
    digested(run, 5, genomes=bytes(SIZE), scores=bytes(SIZE))
    refit(run, 5)
    assert generations(verify(run, everything=True)) == [5]


def test_a_previous_checkpoint_of_another_run_is_a_difference(run):
    genomes = np.tile(run.checkpoint.genomes, 2)
    forge_checkpoint(run, "population.previous.pickle", genomes=genomes)
    assert "does not belong to the run" in str(verify(run).differences[0])


def test_genes_out_of_bounds_are_not_moved(run):
    before = read_checkpoint(run.path / "population.previous.pickle")
    forge_checkpoint(run, "population.previous.pickle", genomes=before.genomes * 1e300)

    def change(record):
        record["genome"][2] = np.nan

    forge_bests(run, 7, change)
    found = [one for one in verify(run).differences if "is out of bounds" in one.what]
    assert {one.generation for one in found} == {7, before.generation}


@pytest.mark.parametrize("name", ["population.pickle", "experiment.toml", "history.csv"])
def test_a_file_of_another_run_is_found(run, puppet, tmp_path, name):
    other = evolve_run(create_run(puppet("seed=2"), tmp_path / "other"))
    (run.path / name).write_bytes((other.path / name).read_bytes())
    with suppress(RunError):  # such a run may be rejected, too
        assert not verify(run).identical


def edit(run, *overrides):
    """Change the experiment's file as by hand."""
    text = with_overrides(run.experiment, parse_assignments(overrides)).to_toml()
    (run.path / "experiment.toml").write_text(text)


@pytest.mark.parametrize(
    ("override", "change"),
    [
        ("seed=77", "seed is 77 in the file, 1 in the run"),
        ("evolution.delta_fitness=7", "evolution.delta_fitness is 7.0 in the file, 0.1 in the run"),
    ],
)
def test_a_changed_experiment_file_is_a_difference(run, override, change):
    edit(run, override)
    for everything in (True, False):
        (found,) = verify(run, everything=everything).differences
        assert found.file == "experiment.toml"
        assert found.what.startswith(change)
    # Once a generation was evolved with the file, it is consistent again.
    evolve_run(run.path, generations=LAST + 1)
    assert verify(run).identical


def test_the_name_and_the_end_of_the_search_may_differ(run):
    ends = ["generations=99", "target_score=50", "max_evaluations=9999", "stagnation=40"]
    edit(run, *(f"evolution.{end}" for end in ends), "name=another")
    path = run.path / "experiment.toml"
    path.write_text("# A remark.\n" + path.read_text())
    assert verify(run, everything=True).identical


def test_bytes_that_no_process_left_behind_are_found_and_cut_off(run):
    path = run.path / "checksums.bin"
    whole = path.read_bytes()
    path.write_bytes(whole + b"more" * 9)
    assert "36 bytes at its end" in str(verify(run).differences[0])
    evolve_run(run.path, generations=LAST + 1)
    assert path.read_bytes()[: len(whole)] == whole
    assert verify(run).identical


def test_a_run_without_generations_cannot_be_verified(puppet, tmp_path):
    with pytest.raises(RunError, match="no finished generation"):
        verify(RunSnapshot(create_run(puppet(), tmp_path / "new")))


# Provenance


def test_origins_are_recorded_when_they_change(tmp_path):
    write_provenance(tmp_path, 1, {"numpy": "1"})
    write_provenance(tmp_path, 5, {"numpy": "1"})
    write_provenance(tmp_path, 8, {"numpy": "2"})
    assert [(one.first, one.parts) for one in read_provenance(tmp_path)] == [
        (1, {"numpy": "1"}),
        (8, {"numpy": "2"}),
    ]
    write_provenance(tmp_path, 6, {"numpy": "3"})  # resumed from an earlier checkpoint
    assert [one.first for one in read_provenance(tmp_path)] == [1, 6]


def test_different_versions_are_reported(run):
    path = run.path / "provenance.json"
    (entry,) = json.loads(path.read_text())
    now = dict(entry["parts"])
    entry["parts"] |= {"numpy": "0.1", "processor": "abacus", "numba": "0.2"}
    path.write_text(json.dumps([entry]))
    expected = {
        f"{name}: {then} then" for name, then in (("numpy", "0.1"), ("processor", "abacus"))
    }
    told = verify(run).version_differences
    assert {text.partition(", ")[0] for text in told} - {"numba: 0.2 then"} == expected
    assert f"numpy: 0.1 then, {now['numpy']} now" in told


@pytest.mark.parametrize(
    "text",
    ["", '[{"first": 1}]', '[{"first": "1", "parts": {}}]', "[" * 100_000],
    ids=["empty", "no parts", "no number", "deep"],
)
def test_damaged_provenance_is_reported(run, text):
    (run.path / "provenance.json").write_text(text)
    with pytest.raises(RunError, match=r"provenance\.json is damaged"):
        verify(run)
    evolve_run(run.path, generations=LAST + 1)  # and does not prevent resuming
    assert [one.first for one in read_provenance(run.path)] == [LAST + 1]
