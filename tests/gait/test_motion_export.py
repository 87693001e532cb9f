"""All channels of motions as tables and arrays: `gaitsim export --format motion`."""

import json

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.contracts import Subject
from gaitsim.gait.channels import motion_columns
from gaitsim_exports.motion import write_motion

SHORT = {
    "spider": {},
    "millipede": {},
    "fly": {"organism.duration": 0.2},
    "walker": {"organism.duration": 0.5},
    "hexapod": {"organism.duration": 0.5},
}


def load(path):
    """Return the arrays of a file, which is closed."""
    with np.load(path) as file:
        return dict(file)


def individual(preset):
    experiment = gs.load_experiment(preset, SHORT[preset])
    genome = experiment.space().random(1, np.random.default_rng(5))[0]
    return gs.Individual(experiment, 1.5, {}, 7, genome)


@pytest.mark.packages
@pytest.mark.parametrize("preset", SHORT)
def test_pandas_reads_the_motion_of_every_body(preset, tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    one = individual(preset)
    for name in ("motion.csv", "motion.parquet"):
        gs.export(one, tmp_path / name, "motion")
    tables = {
        "csv": pandas.read_csv(tmp_path / "motion.csv"),
        "parquet": pandas.read_parquet(tmp_path / "motion.parquet"),
        "memory": one.to_pandas(),
    }
    declared = one.experiment.organism.channels
    for table in tables.values():
        assert list(table.columns) == list(tables["memory"].columns)
        for name, channel in declared.items():
            size = one.motion[name][0].size
            shape = one.motion[name].shape[1:]
            trials = shape[channel.axes.index("trials")] if "trials" in channel.axes else 1
            frames = shape[0] if channel.over_time else 1
            columns = [label for label in table if label.split(" ")[0] == name]
            assert len(columns) == size // trials // frames
            if channel.unit and isinstance(channel.unit, str):
                assert all(label.endswith(f" ({channel.unit})") for label in columns)
        rate = one.motion.frame_rate
        assert table["time (s)"].to_numpy() == pytest.approx(table["frame"] / rate)
        assert set(table["generation"]) == {7}
        numbers = table.to_numpy(dtype=float)
        assert np.array_equal(numbers, tables["memory"].to_numpy(dtype=float))


def test_columns_have_the_values_of_the_channels():
    spider, fly = individual("spider"), individual("fly")
    columns = motion_columns(spider)
    feet = spider.motion["feet"][0]
    names = spider.skeleton.contact_names
    assert np.array_equal(columns[f"feet {names[3]} z (m)"], feet[:, 3, 2])
    assert np.array_equal(columns["pose yaw (rad)"], spider.motion["pose"][0, :, 2])
    assert columns[f"stance {names[0]}"].dtype == bool
    assert set(columns["stride_frequency (Hz)"]) == set(spider.motion["stride_frequency"])
    columns = motion_columns(fly)
    second = columns["trial"] == 2
    position = fly.motion["position"][0]
    assert np.array_equal(columns["position z (m)"][second], position[:, 1, 2])
    assert np.array_equal(columns["frame"][second], np.arange(len(position)))


def test_a_body_that_declares_nothing_has_all_channels_of_its_motion(tmp_path):
    space = gs.RealSpace(np.zeros(2), np.ones(2), ("a", "b"))

    def body(genomes):
        return {"place": genomes, "score": genomes.sum(axis=1), "time": genomes, "about": genomes}

    search = gs.evolve(body=body, space=space, fitness=lambda m: m["score"], generations=1, seed=1)
    for _ in search:
        pass
    one = search.champion
    for suffix in ("csv", "npz"):
        gs.export(one, tmp_path / f"a.{suffix}", "motion")
    head, row = (line.split(",") for line in (tmp_path / "a.csv").read_text().splitlines())
    found = dict(zip(head, map(float, row), strict=True))
    assert (found["place entry 1"], found["place entry 2"]) == tuple(one.genome)
    assert found["score"] == found["channel score"] == one.score
    arrays = load(tmp_path / "a.npz")
    for name in ("place", "channel time", "channel about"):
        assert np.array_equal(arrays[name], [one.genome])
    assert json.loads(str(arrays["about"]))["channels"]["place"]["axes"] == [
        "individual",
        ["entry 1", "entry 2"],
    ]
    with pytest.raises(gs.GaitsimError, match="has one value per gait"):
        one.plot("channel", channel="place")


def test_arrays_have_axes_and_units(tmp_path):
    fly = individual("fly")
    said = gs.export(fly, tmp_path / "fly.npz", "motion").summary
    assert said == "1 individual, 7 channels"
    with np.load(tmp_path / "fly.npz") as file:
        found, about = dict(file), json.loads(str(file["about"]))
    assert np.array_equal(found["position"][0], fly.motion["position"][0])
    assert len(found["time"]) == found["position"].shape[1]
    assert about["channels"]["position"]["axes"] == [
        "individual",
        "frame",
        ["trial 1", "trial 2", "trial 3"],
        ["x", "y", "z"],
    ]
    assert about["channels"]["course"]["unit"] == ["m", "m", "m", "rad"]
    assert about["frame_rate"] == 100


def test_whole_populations_are_exported(gaitsim, finished, tmp_path):
    (evolved,) = tmp_path.glob("runs/*")
    run = gs.load(evolved)
    size, last = run.experiment.evolution.population, run.generation
    said = gaitsim("export", run.path, "--format", "motion", "--population", "last").stdout
    assert f"{size} individuals" in said
    run.export(tmp_path / "some.npz", "motion", population="every 2")
    found = load(tmp_path / "some.npz")
    assert found["generation"].tolist() == sorted([*range(2, last + 1, 2)] * size)
    assert found["individual"].tolist() == [*range(1, size + 1)] * (last // 2)
    bests = [found["score"][found["generation"] == n].max() for n in range(2, last + 1, 2)]
    assert bests == run.history["best"][1::2].tolist()
    run.export(tmp_path / "all.csv", "motion", every=1)
    lines = (tmp_path / "all.csv").read_text().splitlines()
    assert {line.split(",")[0] for line in lines[1:]} == {str(n) for n in range(1, last + 1)}


def test_damage_applies_to_all_individuals(tmp_path):
    for _ in gs.evolve("spider", generations=2, population=4, seed=1, out=tmp_path / "run"):
        pass
    run = gs.load(tmp_path / "run")
    subject = Subject(run.snapshot, (run.replay(damage="L2 lost"),))
    write_motion(subject, tmp_path / "a.npz", 1, None)
    found = load(tmp_path / "a.npz")
    assert found["score"].tolist() == [run.replay(n, damage="L2 lost").score for n in (1, 2)]
    with pytest.raises(gs.GaitsimError, match="cannot be combined with --every"):
        run.export(tmp_path / "b.npz", "motion", generations=[1, 2], every=1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"population": "some"}, "invalid generations: 'some'"),
        ({"population": "every 99"}, "no generation to export"),
        ({"population": "9" * 5000}, "invalid generations"),
        ({"every": 1, "population": "last"}, "cannot be combined"),
    ],
)
def test_wrong_generations_are_one_message(finished, tmp_path, options, words):
    with pytest.raises(gs.GaitsimError, match=words):
        gs.load("puppet").export(tmp_path / "a.csv", "motion", **options)
    with pytest.raises(gs.GaitsimError, match=r"need a whole run|cannot be combined"):
        gs.load("puppet").champion.export(tmp_path / "a.csv", "motion", **options)
