"""Any change of a run is found, and its generation named."""

import json
from dataclasses import replace

import numpy as np
import pytest
from run_helpers import evolve_run

from gaitsim.errors import RunError
from gaitsim.evaluation import evaluate
from gaitsim.experiment import parse_assignments, with_overrides
from gaitsim.storage.consistency import expected_chain
from gaitsim.storage.creation import champion_of, create_run, fork_run
from gaitsim.storage.files.checkpoint import pack, read_champion, read_checkpoint
from gaitsim.storage.files.records import RECORD, SIZE, genomes_checksum, scores_checksum
from gaitsim.storage.provenance import read_provenance, write_provenance
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import restore_generation
from gaitsim.storage.verification import verify as verify_snapshot

LAST = 12


def verify(run, *arguments, **options):
    """Verify a run as it is now; by default a part of it, as of a run that took long."""
    options = {"everything": False} | options
    return verify_snapshot(RunSnapshot(run.path), *arguments, **options)


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


def everything(run):
    return verify(run, everything=True, workers=1)


def test_a_run_of_stages_is_identical(run):
    verdict = everything(run)
    assert verdict.identical, verdict.differences
    assert verdict.reproduced == tuple(range(1, LAST + 1))
    assert (verdict.warning, verdict.version_differences) == ("", ())
    assert verdict.damaged == ()
    assert [origin.first for origin in verdict.origins] == [1]
    sampled = verify(run, workers=1)
    assert sampled.identical, sampled.differences
    assert (sampled.reproduced, sampled.best_only) == ((1, 10, 11, LAST), tuple(range(2, 10)))
    assert not sampled.complete
    # A stage's first generations and its last ones, all evaluated with their own fitness.
    assert verify(run, [4, 5, 8, 9], workers=1).identical


def test_forks_and_runs_from_an_individual_are_identical(run, puppet, tmp_path):
    fork = RunSnapshot(fork_run(run.path, overrides={"mutation.plugin": "puppet-jitter"}))
    assert everything(fork).identical
    assert verify(fork, workers=1).best_only[-1] == LAST  # the generation before it is not kept
    evolve_run(fork.path, generations=LAST + 2)
    assert everything(fork).identical
    begun = create_run(puppet(), tmp_path / "begun", champion_of(run, 3))
    assert everything(evolve_run(begun)).identical


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


def one_gene(genomes, individual=3):
    forged = genomes.copy()
    forged[individual, 1] += 1e-9
    return forged


@pytest.mark.parametrize("generation", [1, 6, LAST])
def test_one_gene_of_a_best_is_found(run, generation):
    def change(record):
        record["genome"][2] += 1e-9

    forge_bests(run, generation, change)
    assert next(iter(verify(run, [3], workers=1).differences)) == generation
    refit(run, generation)
    # The digest matches, but moving the individual reveals the change, as does reproducing the run.
    assert [*verify(run, [generation], workers=1).differences] == [generation]
    assert next(iter(everything(run).differences)) == generation


@pytest.mark.parametrize(
    ("column", "value"), [("mean", 0.5), ("reach", 0.25), ("diversity", 0.1), ("worst", -3.0)]
)
def test_one_number_of_the_history_is_found(run, column, value):
    forge_history(run, 7, column, value)
    (found,) = verify(run, [1], workers=1).differences.items()
    files = "history.csv, bests.bin or checksums.bin"
    assert found == (7, [f"its row or record of {files} was changed"])
    refit(run, 7)
    verdict = everything(run)
    assert [*verdict.differences] == [7]
    assert verdict.differences[7][0].startswith(f"history.csv: {column} is {value}, but ")
    assert verdict.reproduced == tuple(range(1, 8))  # up to the first difference


def test_one_score_is_found(run):
    forge_history(run, 7, "best", 0.5)
    assert "best is 0.5 in history.csv" in verify(run, [1], workers=1).differences[7][0]

    def change(record):
        record["score"] = 0.5

    forge_bests(run, 7, change)
    refit(run, 7)
    assert verify(run, [7], workers=1).differences[7][0].startswith("the score of its best")


def test_one_gene_of_the_checkpoint_is_found(run):
    forged = forge_checkpoint(run, genomes=one_gene(run.checkpoint.genomes))
    found = verify(run, [1], workers=1).differences
    assert found[LAST][0] == "the genomes in population.pickle do not match checksums.bin"
    # A forger may adapt digests, scores and the row; reproducing the generation reveals it.
    evaluation = evaluate(run.experiment, forged.genomes)
    forge_checkpoint(run, scores=evaluation.scores, terms=evaluation.terms)
    digested(
        run, LAST, genomes=genomes_checksum(forged.genomes), scores=scores_checksum(evaluation)
    )
    generation = restore_generation(read_checkpoint(run.path / "population.pickle"))
    from gaitsim.storage.files.history import row

    space = run.experiment.space()
    generation = replace(generation, diversity=float(space.diversity(forged.genomes)))
    for column, value in row(generation).items():
        if column not in ("seconds", "generation", "stage", "evaluations"):
            forge_history(run, LAST, column, value)
    refit(run, LAST)
    assert [*verify(run, [1], workers=1).differences] == []  # it was not asked for
    for verdict in (verify(run, workers=1), everything(run)):
        assert [*verdict.differences] == [LAST]
        texts = verdict.differences[LAST]
        assert any("gene 2 of individual 3 differs" in text for text in texts), texts


def cut(data):
    return data[:50]


def flipped(data):
    return data[:-9] + bytes([data[-9] ^ 1]) + data[-8:]


@pytest.mark.parametrize("spoilt", [cut, flipped, lambda data: b""])
@pytest.mark.parametrize("name", ["population.pickle", "population.previous.pickle"])
def test_a_damaged_checkpoint_is_a_difference(run, name, spoilt):
    path, before = run.path / name, run.previous.generation
    path.write_bytes(spoilt(path.read_bytes()))
    for verdict in (everything(run), verify(run, workers=1)):
        assert not verdict.identical
        (text,) = verdict.damaged
        assert text.startswith(f"cannot read {name} as a checkpoint: it is ")
        # The remaining files are compared.
        assert verdict.differences == {}
        left = before if name == "population.pickle" else LAST
        assert max(verdict.reproduced + verdict.best_only) == verdict.last == left


def test_a_missing_checkpoint_is_a_difference_unless_it_is_the_previous_one(run):
    (run.path / "population.previous.pickle").rename(run.path / "kept")
    assert everything(run).identical
    (run.path / "kept").rename(run.path / "population.previous.pickle")
    (run.path / "population.pickle").unlink()
    verdict = everything(run)
    assert not verdict.identical
    assert "cannot read population.pickle as a checkpoint: file not found" in verdict.damaged[0]


@pytest.mark.parametrize(
    "changes", [{"best_score": 99.0}, {"stagnation": 7}, {"threshold": 99.0}, {"threshold": None}]
)
def test_the_progress_in_the_checkpoint_is_compared(run, changes):
    forge_checkpoint(run, **changes)
    assert [*verify(run, [1], workers=1).differences] == [LAST]


@pytest.mark.parametrize("threshold", [-1.0, None])
def test_the_threshold_of_a_copy_is_not_below_the_option(run, threshold):
    (run.path / "population.previous.pickle").unlink()
    assert verify(run, [1], workers=1).identical
    forge_checkpoint(run, threshold=threshold)
    assert [*verify(run, [1], workers=1).differences] == [LAST]


@pytest.mark.parametrize("generation", [1, 5, LAST])
@pytest.mark.parametrize("at", [0, SIZE, 2 * SIZE])
def test_each_checksum_that_was_changed_is_found(run, generation, at):
    path = run.path / "checksums.bin"
    data = bytearray(path.read_bytes())
    data[(generation - 1) * RECORD.itemsize + at + 7] ^= 1
    path.write_bytes(data)
    # Only the third generation is reproduced here.
    assert next(iter(verify(run, [3], workers=1).differences)) == generation


def test_generations_that_were_not_reproduced_are_named(run):
    assert verify(run, [1, 2, 7], workers=1).not_reproduced == ((3, 6), (8, LAST))
    assert verify(run, [LAST], workers=1).not_reproduced == ((1, LAST - 1),)
    assert everything(run).not_reproduced == ()


def of_another_run(run):
    return {"genomes": np.tile(run.checkpoint.genomes, 2)}


def of_another_experiment(run):
    return {"experiment": with_overrides(run.experiment, {"seed": 9}).to_toml()}


@pytest.mark.parametrize("changes", [of_another_run, of_another_experiment])
def test_a_previous_checkpoint_of_another_run_is_a_difference(run, changes):
    forge_checkpoint(run, "population.previous.pickle", **changes(run))
    verdict = verify(run, workers=1)
    (text,) = verdict.damaged
    assert "population.previous.pickle does not belong to the run" in text


def test_genes_out_of_bounds_are_not_moved(run):
    before = read_checkpoint(run.path / "population.previous.pickle")
    forge_checkpoint(run, "population.previous.pickle", genomes=before.genomes * 1e300)
    assert "is out of bounds" in verify(run, workers=1).differences[before.generation][-1]

    def change(record):
        record["genome"][2] = np.nan

    forge_bests(run, 7, change)
    assert "is out of bounds" in verify(run, [7], workers=1).differences[7][-1]


def test_a_champion_is_compared(run):
    path = next(iter(sorted((run.path / "champions").glob("*.pickle"))))
    champion = read_champion(path)
    path.write_bytes(pack(replace(champion, genome=champion.genome + 1e-9)))
    found = verify(run, [LAST], workers=1).differences
    assert [*found] == [champion.generation]
    assert "the genomes in champions/" in found[champion.generation][0]
    path.write_bytes(b"no champion")
    assert [*verify(run, [LAST], workers=1).differences] == [champion.generation]


def test_an_option_that_was_changed_is_found(run):
    """The experiment has changed, so the reproduced generations differ."""
    checkpoint = run.checkpoint
    other = with_overrides(run.experiment, {"seed": 2}).to_toml()
    forge_checkpoint(
        run, stages=(replace(checkpoint.stages[0], experiment=other), *checkpoint.stages[1:])
    )
    verdict = everything(run)
    assert next(iter(verdict.differences)) == 1
    assert "the reproduced genomes do not match checksums.bin" in verdict.differences[1]


def edit(run, *overrides):
    """Change the experiment's file as by hand."""
    text = with_overrides(run.experiment, parse_assignments(overrides)).to_toml()
    (run.path / "experiment.toml").write_text(text)
    return RunSnapshot(run.path)


@pytest.mark.parametrize(
    ("override", "change"),
    [
        ("seed=77", ("seed", 1, 77)),
        ("mutation.plugin=none", ("mutation.plugin", "puppet-jitter", "none")),
        ("fitness.price=0.9", ("fitness.price", 0.4, 0.9)),
        ("search.elites=2", ("search.elites", 1, 2)),
        ("evolution.fitness_threshold=7", ("evolution.fitness_threshold", 0.0, 7.0)),
        ("evolution.delta_fitness=7", ("evolution.delta_fitness", 0.1, 7.0)),
    ],
)
def test_a_changed_experiment_file_is_a_difference(run, override, change):
    edited = edit(run, override)
    for verdict in (everything(edited), verify(edited, [2, LAST], workers=1)):
        assert not verdict.identical
        assert [(one.key, one.then, one.now) for one in verdict.edited] == [change]
        assert (verdict.differences, verdict.damaged) == ({}, ())
    # Once a generation was evolved with the file, it is consistent again.
    evolve_run(run.path, generations=LAST + 1)
    assert verify(RunSnapshot(run.path), workers=1).identical


def test_the_name_and_the_end_of_the_search_may_differ(run):
    ends = ["generations=99", "target_score=50", "max_evaluations=9999", "stagnation=40"]
    edited = edit(run, *(f"evolution.{end}" for end in ends), "name=another")
    path = run.path / "experiment.toml"
    path.write_text("# A remark.\n" + path.read_text())
    assert everything(edited).identical
    assert everything(edited).edited == ()


def test_a_stage_that_has_not_started_is_reported(run):
    fork = RunSnapshot(fork_run(run.path, overrides={"fitness.price": 0.2}, generations=LAST + 2))
    verdict = everything(fork)
    assert ([one.key for one in verdict.edited], verdict.differences) == (["fitness.price"], {})
    evolve_run(fork.path)
    assert everything(RunSnapshot(fork.path)).identical


def test_a_quick_run_is_reproduced_as_a_whole(run):
    verdict = verify(run, everything=None, workers=1)
    assert verdict.complete
    assert verdict.identical


def test_records_are_cut_back_to_the_checkpoint(run):
    path = run.path / "checksums.bin"
    whole = path.read_bytes()
    path.write_bytes(whole + b"left by a killed process" * 9)
    assert verify(run, workers=1).identical
    evolve_run(run.path, generations=LAST + 1)
    assert path.read_bytes()[: len(whole)] == whole
    assert len(path.read_bytes()) == len(whole) + RECORD.itemsize


def test_requested_generations_must_exist(run, puppet, tmp_path):
    for asked in ([0], [LAST + 1], [1, 99]):
        with pytest.raises(RunError, match=f"no generation {asked[-1]}"):
            verify(run, asked)
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
    told = verify(run, [1], workers=1).version_differences
    assert {text.partition(", ")[0] for text in told} - {"numba: 0.2 then"} == expected
    assert f"numpy: 0.1 then, {now['numpy']} now" in told


@pytest.mark.parametrize(
    "text",
    ["", "{}", "[1]", '[{"first": 1}]', '[{"first": "1", "parts": {}}]', "[" * 100_000],
    ids=["empty", "no list", "no entry", "no parts", "no number", "deep"],
)
def test_damaged_provenance_is_reported(run, text):
    (run.path / "provenance.json").write_text(text)
    with pytest.raises(RunError, match=r"provenance\.json is damaged"):
        verify(run, [1], workers=1)
    evolve_run(run.path, generations=LAST + 1)  # and does not prevent resuming
    assert [one.first for one in read_provenance(run.path)] == [LAST + 1]
