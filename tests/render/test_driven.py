"""Videos and pages of driven robots: the command, and no curve of a single generation."""

import numpy as np
import pytest

from gaitsim.experiment import load_experiment
from gaitsim.individual import Individual
from gaitsim.render.film import RenderSettings
from gaitsim.render.scene.clip import clip_of, format_command
from gaitsim.render.scene.labels import format_moment, widest_moment
from gaitsim.render.video import Video
from gaitsim.steering import save_drive
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_page.clips import clip_data

DRIVE = [{"at": 0.0, "speed": 0.1}, {"at": 1.0, "turn": -20.0}]


@pytest.mark.parametrize(
    ("command", "text"),
    [
        ((0.0, 0.0, 0.0, 0.0), "command 0.00 m/s"),
        ((-0.001, 0.001, 0.001, 0.0), "command 0.00 m/s"),
        ((-0.2, np.radians(30), 0.0, 0.0), "command −0.20 m/s, 30 °/s left"),
        (
            (0.2, -np.radians(5), -0.05, -0.012),
            "command 0.20 m/s, 5 °/s right, 0.05 m/s right, −1.2 cm",
        ),
    ],
)
def test_commands_are_text(command, text):
    assert format_command(command) == text


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    experiment = load_experiment("hexapod")
    genome = next(iter(experiment.organism.starts().values()))
    options = {"drive": DRIVE, "duration": 2.0}
    path = save_drive(experiment, genome, options, 2.0, tmp_path_factory.mktemp("drive") / "drive")
    return RunSnapshot(path)


def test_a_picture_and_a_page_show_the_command(run):
    individual = run.individual()
    clip = clip_of(individual)
    last = "command 0.10 m/s, 20 °/s right"
    assert clip.said[-1] == last
    assert format_moment(clip, clip.at(9.0), 9.0).endswith(last)
    assert len(widest_moment(clip)) == len(format_moment(clip, clip.at(9.0), 9.0))
    said = clip_data(individual)["said"]
    assert said[0][0] == 0
    assert said[-1][1] == last
    frames = [frame for frame, _ in said]
    assert frames == sorted(set(frames))
    assert len(frames) < len(clip.said)


def test_a_gait_without_a_drive_has_no_command():
    experiment = load_experiment(
        "hexapod", {"organism.reflexes": {"heading": {}}, "organism.duration": 0.5}
    )
    genome = next(iter(experiment.organism.starts().values()))
    assert clip_of(Individual(experiment, 0.0, {}, 1, genome)).said == ()


def test_the_video_of_a_single_generation_has_no_curve(run, spider_run):
    settings = RenderSettings(size=(128, 96))
    assert len(Video(run, (), settings)) == 61
    spider = len(Video(spider_run, (), RenderSettings(size=(128, 96), intro=False)))
    assert len(Video(spider_run, (), settings)) == spider + 45
