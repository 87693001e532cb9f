"""Event files, read back by TensorBoard."""

import io
import sys

import numpy as np
import pytest
from PIL import Image

from gaitsim.errors import GaitsimError, RunError
from gaitsim.storage.creation import create_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_exports import tensorboard
from gaitsim_exports.tensorboard import FILE, write_events

SCORES = "best", "mean", "median", "lower quartile", "upper quartile", "worst", "std"
PLAIN = "stage", "evaluations", "diversity", "seconds"


def tag_of(column):
    """Return the tag of a column in TensorBoard."""
    if column in PLAIN:
        return column
    before, _, term = column.rpartition(":")
    group = {"mean": "mean of terms", "search": "search", "": "terms"}[before]
    return f"score/{column}" if column in SCORES else f"{group}/{term}"


@pytest.fixture
def events(tmp_path):
    """A function that reads the events of a folder by tag."""
    pytest.importorskip("tensorboardX", reason="needs the extra tensorboard")
    accumulators = pytest.importorskip(
        "tensorboard.backend.event_processing.event_accumulator", reason="needs TensorBoard"
    )

    def read(folder):
        everything = {"scalars": 0, "images": 0, "tensors": 0}
        return accumulators.EventAccumulator(str(folder), everything).Reload()

    return read


def assert_same(found, history):
    """Check that all columns of a history are written, except values that a stage lacks."""
    scalars = {*found.Tags()["scalars"]} - {"champion/score"}
    assert len(scalars) == len(history) - 1
    times = np.cumsum(history["seconds"])
    for name, values in history.items():
        if name == "generation":
            continue
        known = ~np.isnan(values)
        read = found.Scalars(tag_of(name))
        assert [one.step for one in read] == history["generation"][known].tolist()
        assert [one.wall_time for one in read] == times[known].tolist()
        assert np.array_equal([one.value for one in read], values[known].astype(np.float32))


def test_tensorboard_reads_everything_back(puppet_run, tmp_path, events):
    run = RunSnapshot(puppet_run("evolution.generations=12").path)
    steps = []
    assert write_events(run, tmp_path / "logs", steps.append) == ()
    assert steps == [1] * 12
    found = events(tmp_path / "logs")
    assert_same(found, run.history)
    (score,), champion = found.Scalars("champion/score"), run.individual()
    assert (score.step, score.value) == (champion.generation, np.float32(champion.score))
    (image,) = found.Images("champion/motion")
    with Image.open(io.BytesIO(image.encoded_image_string)) as gif:
        assert (gif.format, gif.size) == ("GIF", (image.width, image.height))
        assert gif.n_frames == 11
    first = (tmp_path / "logs" / FILE).read_bytes()
    write_events(RunSnapshot(run.path), tmp_path / "logs")
    assert (tmp_path / "logs" / FILE).read_bytes() == first


def test_options_are_hyperparameters_with_the_final_score(puppet_run, tmp_path, events):
    messages = pytest.importorskip("tensorboard.plugins.hparams.plugin_data_pb2")
    run = RunSnapshot(puppet_run("evolution.generations=2").path)
    write_events(run, tmp_path / "logs")
    data = events(tmp_path / "logs").SummaryMetadata
    start, whole = (
        messages.HParamsPluginData.FromString(data(f"_hparams_/{tag}").plugin_data.content)
        for tag in ("session_start_info", "experiment")
    )
    options = run.outline.options()
    found = {
        name: getattr(value, value.WhichOneof("kind"))
        for name, value in start.session_start_info.hparams.items()
    }
    assert found.keys() == options.keys()
    assert found["seed"] == options["seed"]
    assert found["organism.plugin"] == "puppet"
    assert [info.name.tag for info in whole.experiment.metric_infos] == ["champion/score"]


def test_missing_values_and_scores_of_failed_individuals(puppet_run, tmp_path, events, monkeypatch):
    run = RunSnapshot(puppet_run("evolution.generations=3").path)
    run.history["worst"][1] = -np.inf
    run.history[[*run.history][-1]][0] = np.nan
    monkeypatch.setattr(tensorboard, "PICTURES", 1)
    write_events(run, tmp_path / "logs")
    assert_same(events(tmp_path / "logs"), run.history)


def test_a_body_that_cannot_be_drawn_leaves_the_scalars(
    puppet_run, puppets, tmp_path, events, monkeypatch
):
    run = RunSnapshot(puppet_run("evolution.generations=2").path)
    monkeypatch.setattr(puppets.Puppet, "skeleton", lambda *_: None)
    (notice,) = write_events(run, tmp_path / "logs")
    assert "no animation" in notice
    found = events(tmp_path / "logs")
    assert_same(found, run.history)
    assert not found.Tags()["images"]


def test_failures_are_reported_in_one_message(puppet, puppet_run, tmp_path, monkeypatch):
    run = RunSnapshot(puppet_run("evolution.generations=2").path)
    (tmp_path / "file").write_text("mine")
    (tmp_path / "other").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "other")
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "tensorboardX", None)
        with pytest.raises(GaitsimError, match="not installed") as raised:
            write_events(run, tmp_path / "logs")
        assert "gaitsim[tensorboard]" in raised.value.remedy
    pytest.importorskip("tensorboardX", reason="needs the extra tensorboard")
    for place in ("file", "link", "missing/logs"):
        with pytest.raises(RunError):
            write_events(run, tmp_path / place)
    assert (tmp_path / "file").read_text() == "mine"
    assert not [*(tmp_path / "other").iterdir()]
    empty = RunSnapshot(create_run(puppet(), tmp_path / "empty"))
    with pytest.raises(RunError, match="no finished generation"):
        write_events(empty, tmp_path / "logs")
    assert not (tmp_path / "logs").exists()
