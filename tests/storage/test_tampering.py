"""`verify` finds every change in the folder of any kind of run."""

import shutil
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from run_helpers import evolve_run

from gaitsim.errors import GaitsimError
from gaitsim.experiment import with_overrides
from gaitsim.storage.creation import champion_of, create_run
from gaitsim.storage.files.checkpoint import pack, read_champion, read_checkpoint, read_start
from gaitsim.storage.files.folder import champion_file
from gaitsim.storage.files.records import RECORD
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import expected_chain, verify_run

CHECKPOINT, PREVIOUS = "population.pickle", "population.previous.pickle"
LAST, MIDDLE = 10, 5
FRONT = ("search.plugin=nsga-2", "search.objectives.reach=max", "search.objectives.price=max")
ARCHIVE = ("search.plugin=map-elites", "search.axes.reach=[-2, 3]", "search.cells=[8]")
KINDS = {
    "plain": (),
    "front": FRONT,
    "archive": ARCHIVE,
    "cma-es": ("search.plugin=cma-es",),
    "islands": ("islands.number=2", "evolution.population=6"),
    "worlds": (
        "organism.plugin=windy-puppet",
        "worlds.cases=[{wind=0.3}, {}]",
        "worlds.number=2",
        "worlds.redraw=3",
    ),
    "stages": (),
    "started": (),
}
SLOW = [pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS if kind != "stages"]
KEEP = ("evolution.fitness_threshold=-20",)


@pytest.fixture(params=["stages", *SLOW])
def run(request, puppet, tmp_path, once):
    """A run that keeps champions, beside a copy of it at an earlier generation."""
    kind = request.param
    path = tmp_path / kind

    def create():
        experiment = puppet("evolution.population=12", *KEEP, *KINDS[kind])
        start = None
        if kind == "started":
            other = create_run(experiment, tmp_path / "other")
            start = champion_of(evolve_run(other, 2))
        create_run(experiment, path, start)
        more = ("fitness.price=0.4",) if kind == "stages" else ()
        evolve_run(path, MIDDLE - 1, generations=LAST)
        evolve_run(path, MIDDLE, generations=LAST)
        earlier = path / "exports" / "earlier"
        earlier.mkdir()
        for name in (CHECKPOINT, PREVIOUS):
            shutil.copy(path / name, earlier / name)
        evolve_run(path, None, *more, generations=LAST)

    return RunSnapshot(once(f"tampering {kind}", path, create))


def found(path, **options):
    """Return whether a verification finds a difference, or that nothing can be verified."""
    try:
        return not verify_run(RunSnapshot(path), workers=1, **options).identical
    except GaitsimError:
        return True


def test_an_untouched_run_is_identical(run):
    for everything in (True, False):
        verdict = verify_run(run, everything=everything, workers=1)
        assert verdict.identical, verdict.differences
        assert not any(one.result == "differs" for one in verdict.files)


# Changes of files, which the files alone reveal


def rolled_back(path, *names):
    for name in names:
        shutil.copy(path / "exports" / "earlier" / name, path / name)


def emptied(path, name):
    (path / name).write_bytes(b"")


def zeroed(path, name):
    (path / name).write_bytes(bytes(len((path / name).read_bytes())))


def shortened(path, name):
    (path / name).write_bytes((path / name).read_bytes()[: -RECORD.itemsize])


def lengthened(path, name, more=b"more\n"):
    (path / name).write_bytes((path / name).read_bytes() + more)


def row_of_history(path):
    return (path / "history.csv").read_bytes().splitlines(keepends=True)[-1]


def champions(path):
    return sorted((path / "champions").iterdir())


def without_champions(path):
    for file in champions(path):
        file.unlink()


def with_another_champion(path):
    numbers = {int(file.stem.partition("-")[2]) for file in champions(path)}
    number = min({*range(1, LAST + 1)} - numbers)
    shutil.copy(champions(path)[0], path / champion_file(number))


def with_champion(path, **changes):
    file = champions(path)[-1]
    champion = read_champion(file)
    if "experiment" in changes:
        changes["experiment"] = with_overrides(RunSnapshot(path).experiment, {"seed": 9}).to_toml()
    file.write_bytes(pack(replace(champion, **changes)))


def with_field(path, name, field):
    """Change a field of a checkpoint."""
    there = read_checkpoint(path / name)
    value = getattr(there, field)
    match value:
        case np.ndarray():
            value = value.copy()
            value.flat[0] -= value.dtype.type(1)
        case dict():
            key = next((key for key in value if value[key].size), None)
            if key is None:
                pytest.skip(f"no {field}")
            changed = value[key].copy()
            changed.flat[-1] += changed.dtype.type(1)
            value = value | {key: changed}
        case "" if field == "finished":
            value = "converged"
        case str():
            experiment = RunSnapshot(path).experiment
            value = with_overrides(experiment, {"seed": 9}).to_toml()
        case None:
            pytest.skip(f"no {field}")
        case _:
            value += -1 if field == "generation" and not there.stages else 1
    (path / name).write_bytes(pack(replace(there, **{field: value})))


FIELDS = ("generation", "genomes", "scores", "terms", "experiment")
PROGRESS = ("evaluations", "stagnation", "best_score", "threshold", "finished")
FILES_REVEAL = {
    "the checkpoint rolled back": lambda path: rolled_back(path, CHECKPOINT),
    "both checkpoints rolled back": lambda path: rolled_back(path, CHECKPOINT, PREVIOUS),
    "checksums deleted": lambda path: (path / "checksums.bin").unlink(),
    "checksums emptied": partial(emptied, name="checksums.bin"),
    "checksums set to zero": partial(zeroed, name="checksums.bin"),
    "a checksum cut off": partial(shortened, name="checksums.bin"),
    **{
        f"bytes after {name}": partial(lengthened, name=name)
        for name in (
            "history.csv",
            "bests.bin",
            "scores.bin",
            "checksums.bin",
            "saves.bin",
            CHECKPOINT,
            PREVIOUS,
        )
    },
    "a row after the last": lambda path: lengthened(path, "history.csv", row_of_history(path)),
    "saves deleted": lambda path: (path / "saves.bin").unlink(),
    "saves set to zero": partial(zeroed, name="saves.bin"),
    "a champion's experiment": partial(with_champion, experiment=""),
    "a champion's score": partial(with_champion, score=99.0),
    "a champion's generation": partial(with_champion, generation=LAST + 1),
}
"""Functions that tamper with a folder, by name."""
for _name in (CHECKPOINT, PREVIOUS):
    for _field in FIELDS:
        FILES_REVEAL[f"{_field} in {_name}"] = partial(with_field, name=_name, field=_field)


@pytest.mark.parametrize("tamper", FILES_REVEAL.values(), ids=FILES_REVEAL)
def test_the_files_reveal_it(run, tamper):
    tamper(run.path)
    assert found(run.path, everything=False)


# Forgeries that are consistent with all checksums, which reproducing the run reveals


def refit(path):
    """Recompute the chain of checksums from the files, as a forger would."""
    for number in range(1, LAST + 1):
        run = RunSnapshot(path)
        records = run.checksums.copy()
        records["chain"][number - 1] = np.void(expected_chain(run, number))
        (path / "checksums.bin").write_bytes(records.tobytes())


def with_other_mean(path):
    lines = (path / "history.csv").read_text().splitlines()
    at = lines[0].split(",").index("mean")
    cells = lines[3].split(",")
    cells[at] = "-7.25"
    (path / "history.csv").write_text("\n".join([*lines[:3], ",".join(cells), *lines[4:]]) + "\n")


def with_other_best(path):
    run = RunSnapshot(path)
    records = run.bests.copy()
    records["genome"][2, 0] += records["genome"].dtype.type(1)
    (path / "bests.bin").write_bytes(records.tobytes())


def with_swapped_generations(path):
    run, two = RunSnapshot(path), [1, 2]
    for name, records in (("bests.bin", run.bests), ("checksums.bin", run.checksums)):
        swapped = records.copy()
        swapped[two] = records[two[::-1]]
        (path / name).write_bytes(swapped.tobytes())
    for name in ("history.csv", "islands.csv"):
        if not (path / name).exists():
            continue
        lines = (path / name).read_text().splitlines()
        first, second = (lines[number + 1].split(",") for number in two)
        kept = [at for at, cell in enumerate(lines[0].split(",")) if cell in KEPT]
        for at in kept:
            first[at], second[at] = second[at], first[at]
        lines[2], lines[3] = ",".join(second), ",".join(first)
        (path / name).write_text("\n".join(lines) + "\n")


KEPT = ("generation", "stage", "evaluations")


def with_state(path):
    for name in (CHECKPOINT, PREVIOUS):
        with_field(path, name, "state")


def with_other_start(path):
    if not (path / "start.pickle").exists():
        pytest.skip("no start")
    start = read_start(path / "start.pickle")
    (path / "start.pickle").write_bytes(pack(replace(start, genomes=start.genomes * 0.5)))


FORGERIES = {
    "champions deleted": without_champions,
    "a champion deleted": lambda path: champions(path)[0].unlink(),
    "a champion added": with_another_champion,
    "a mean": with_other_mean,
    "the genome of a best": with_other_best,
    "two generations swapped": with_swapped_generations,
    "the state of the search": with_state,
    "the state in the previous checkpoint": partial(with_field, name=PREVIOUS, field="state"),
    "the values in a checkpoint": partial(with_field, name=CHECKPOINT, field="values"),
    "the start": with_other_start,
    **{
        f"{field} in {name}": partial(with_field, name=name, field=field)
        for name in (CHECKPOINT, PREVIOUS)
        for field in PROGRESS
    },
}


@pytest.mark.parametrize("tamper", FORGERIES.values(), ids=FORGERIES)
def test_reproducing_the_run_reveals_it(run, tamper):
    tamper(run.path)
    refit(run.path)
    assert found(run.path)


def test_a_killed_process_is_no_forgery(run):
    """The records of a save may be written before a process is killed, and its checkpoint not."""
    path = run.path
    before = {name: (path / name).read_bytes() for name in (CHECKPOINT, PREVIOUS)}
    evolve_run(path, generations=LAST + 1)
    for name, data in before.items():
        (path / name).write_bytes(data)
    verdict = verify_run(RunSnapshot(path), workers=1)
    assert verdict.identical, verdict.differences
    evolve_run(path, generations=LAST + 2)
    assert verify_run(RunSnapshot(path), workers=1).identical
    for name, data in before.items():
        (path / name).write_bytes(data)
    assert found(path)


def test_a_run_that_evolves_is_not_rolled_back(run, monkeypatch):
    monkeypatch.setattr("gaitsim.storage.verification.is_locked", lambda path: True)
    before = {name: (run.path / name).read_bytes() for name in (CHECKPOINT, PREVIOUS)}
    evolve_run(run.path, LAST + 1, generations=LAST + 2)
    evolve_run(run.path, generations=LAST + 2)
    for name, data in before.items():
        (run.path / name).write_bytes(data)
    assert verify_run(RunSnapshot(run.path), everything=False, workers=1).identical
