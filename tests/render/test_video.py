import errno
import gc
import os
import weakref
from fractions import Fraction

import av
import numpy as np
import pytest
from PIL import Image

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError, PluginError, RunError
from gaitsim.render.encoder import (
    ENOUGH,
    default_speed,
    encode,
    is_resolved,
    movement_frequency,
    palette,
)
from gaitsim.render.film import RenderSettings
from gaitsim.render.scene import Scene
from gaitsim.render.video import Video

SMALL = {"size": (128, 96), "intro": False}


def decoded(path):
    """Return the codec, rate and pixel format of a video, and its pictures, (pictures, …, 3)."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        facts = (stream.codec_context.name, stream.average_rate)
        pictures = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
        return facts, stream.codec_context.pix_fmt, np.stack(pictures)


def plain(count, size=(64, 48)):
    """Yield pictures of a uniform grey that becomes brighter."""
    width, height = size
    for number in range(count):
        picture = np.full((height, width, 4), 255, np.uint8)
        picture[..., :3] = 20 + 10 * number
        yield picture


def noise(count, size=(64, 48)):
    rng = np.random.default_rng(0)
    for _ in range(count):
        yield rng.integers(0, 255, (size[1], size[0], 4), dtype=np.uint8)


def write(path, pictures, format="mp4", fps=10, size=(64, 48)):
    samples = list(plain(2)) if format == "gif" else ()
    encode(pictures, path, format=format, size=size, fps=Fraction(fps), samples=samples)


def test_an_mp4_has_a_format_that_browsers_play(tmp_path):
    write(tmp_path / "a.mp4", plain(8), fps=25)
    facts, pixels, pictures = decoded(tmp_path / "a.mp4")
    assert facts == ("h264", 25)
    assert pixels == "yuv420p"
    assert pictures.shape == (8, 48, 64, 3)
    assert np.abs(pictures[:, 10, 10, 1] - np.arange(20, 100, 10.0)).max() <= 4
    content = (tmp_path / "a.mp4").read_bytes()  # the index comes before the pictures
    assert 0 < content.index(b"moov") < content.index(b"mdat")


def test_colours_are_preserved(tmp_path):
    picture = np.full((48, 64, 4), 255, np.uint8)
    for left, colour in ((0, (213, 94, 0)), (20, (0, 114, 178)), (40, (246, 244, 239))):
        picture[:, left : left + 20, :3] = colour
    for format in ("mp4", "gif"):
        path = tmp_path / f"a.{format}"
        encode([picture], path, format=format, size=(64, 48), fps=Fraction(5), samples=[picture])
        _, _, (shown,) = decoded(path)
        for column in (8, 28, 48):
            difference = shown[24, column].astype(int) - picture[24, column, :3]
            assert np.abs(difference).max() <= 8


def test_all_colours_of_a_gif_are_near_the_drawn_ones():
    rng = np.random.default_rng(2)
    ramps = np.linspace(0, 255, 40)[:, None] * rng.random((6, 1, 3))
    picture = np.full((6, 40, 4), 255, np.uint8)
    picture[..., :3] = ramps
    exact = np.array([(213, 94, 0), (218, 95, 0)], np.uint8)
    colours, indices = palette([picture], exact)
    assert len(colours) <= 256
    cells = picture[..., :3].astype(int) // 4
    found = colours[indices[(cells[..., 0] * 64 + cells[..., 1]) * 64 + cells[..., 2]]]
    assert np.abs(found.astype(int) - picture[..., :3]).max() <= 16
    assert {(213, 94, 0), (218, 95, 0)} <= {tuple(colour) for colour in colours.tolist()}


def test_a_gif_repeats_forever_at_its_rate(tmp_path):
    write(tmp_path / "a.gif", plain(6), "gif", fps=20)
    with Image.open(tmp_path / "a.gif") as gif:
        assert (gif.n_frames, gif.size) == (6, (64, 48))
        assert gif.info["loop"] == 0
        assert gif.info["duration"] == 50


@pytest.mark.parametrize("format", ["mp4", "gif"])
def test_pictures_are_not_kept_in_memory(tmp_path, format):
    alive, most = [], 0

    def pictures():
        nonlocal most
        for picture in noise(120):
            alive.append(weakref.ref(picture))
            most = max(most, sum(ref() is not None for ref in alive))
            yield picture

    gc.disable()
    try:
        write(tmp_path / "a", pictures(), format)
    finally:
        gc.enable()
    assert len(alive) == 120
    assert most <= 3


@pytest.mark.parametrize("format", ["mp4", "gif"])
def test_a_full_disk_keeps_the_old_file_and_gives_one_message(tmp_path, monkeypatch, format):
    (tmp_path / "a").write_text("old")

    def full(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RunError, match="cannot write a: No space left"):
        write(tmp_path / "a", plain(3), format)
    assert (tmp_path / "a").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("stop", [KeyboardInterrupt, ZeroDivisionError])
def test_an_interrupted_video_leaves_no_file(tmp_path, stop):
    def pictures():
        yield from noise(30)
        raise stop

    with pytest.raises(stop):
        write(tmp_path / "a.mp4", pictures())
    assert list(tmp_path.iterdir()) == []


def test_a_video_begins_with_the_fitness_curve(spider_run):
    video = Video(spider_run, (), RenderSettings(size=(320, 240), theme="dark"))
    assert len(video) == 45 + 300
    pictures = [picture for picture, _ in zip(video.pictures(), range(46), strict=False)]
    assert all(np.array_equal(pictures[0], picture) for picture in pictures[:33])
    assert not np.array_equal(pictures[33], pictures[32])
    bare = next(
        iter(
            Video(
                spider_run, (), RenderSettings(size=(320, 240), theme="dark", intro=False)
            ).pictures()
        )
    )
    assert np.array_equal(pictures[45], bare)
    background = pictures[0][0, 0]
    assert (pictures[0][[0, -1]] == background).all()  # nothing is cut off
    assert (pictures[0][:, [0, -1]] == background).all()
    assert (pictures[0] != background).any(axis=-1).mean() > 0.05


@pytest.mark.parametrize(
    ("speed", "fps", "pictures"), [(1, 30, 300), (0.5, 30, 599), (2, 30, 150), (1, 10, 100)]
)
def test_speed_and_rate_resample_the_motion(spider_run, speed, fps, pictures):
    video = Video(spider_run, (), RenderSettings(speed=speed, fps=fps, **SMALL))
    assert len(video) == pictures


def test_slow_motion_interpolates_between_frames(spider_run, monkeypatch):
    seen = []
    draw = Scene.draw

    def record(self, seconds, turned=0.0):
        seen.append((seconds, turned))
        return draw(self, seconds, turned)

    monkeypatch.setattr(Scene, "draw", record)
    settings = RenderSettings(speed=0.25, fps=60, view="orbit", **SMALL)
    for _, _ in zip(Video(spider_run, (), settings).pictures(), range(5), strict=False):
        pass
    times = np.array(seen)
    assert np.allclose(times[:5, 0], np.arange(5) / 240)
    assert (np.diff(times[:5, 1]) > 0).all()


def test_champions_of_several_generations_race(spider_run):
    video = Video(spider_run, (1, 3, 2), RenderSettings(size=(480, 160), intro=False))
    assert video.name == "video-generations-1-3-2.mp4"
    titles = [clip.title for clip in video.scene.world.clips]
    assert titles == ["generation 1", "generation 3", "generation 2"]
    assert [clip.tag for clip in video.scene.world.clips] == ["1", "3", "2"]


def test_one_generation_is_named_in_file_and_heading(spider_run):
    video = Video(spider_run, (2,), RenderSettings("gif", **SMALL))
    assert video.name == "video-generation-2.gif"
    title, details = video.scene.heading
    assert title == "spider"
    assert details.startswith("generation 2   score ")


@pytest.mark.slow
def test_the_same_video_is_the_same_file(spider_run, tmp_path):
    for format in ("mp4", "gif"):
        paths = [tmp_path / f"{name}.{format}" for name in "ab"]
        for path in paths:
            Video(spider_run, (), RenderSettings(format, (160, 120), fps=2, speed=5)).write(path)
        assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"format": "avi"}, "format 'avi'"),
        ({"view": "sides"}, "view 'sides'"),
        ({"size": (641, 480)}, "H.264 requires even numbers"),
        ({"fps": float("nan")}, "nan frames per second"),
        ({"format": "gif", "fps": 60.0}, "frames per second"),
        ({"speed": 0.0}, "invalid speed: 0"),
    ],
)
def test_invalid_settings_are_rejected(settings, message):
    with pytest.raises(GaitsimError, match=message) as error:
        RenderSettings(**settings)
    assert error.value.where.startswith("--")
    assert error.value.allowed


def test_too_many_bodies_are_rejected(spider_run):
    with pytest.raises(GaitsimError, match="7 bodies do not fit") as error:
        Video(spider_run, (1, 2, 3, 1, 2, 3, 1), RenderSettings(**SMALL))
    assert "--size" in error.value.remedy


@pytest.mark.parametrize(
    ("skeleton", "message"),
    [
        (lambda *_: Skeleton(np.full((2, 1, 2, 3), np.nan), ("a",), 1.0), "cannot be drawn"),
        (lambda *_: Skeleton(np.zeros((2, 1, 2, 3)), ("a",), 0.0), "frame rate of the body is 0.0"),
        (lambda *_: None, "returned a NoneType"),
        (lambda *_: 1 / 0, "drawing the champion: ZeroDivisionError"),
    ],
)
@pytest.mark.filterwarnings("ignore:Mean of empty slice", "ignore:invalid value")
def test_a_body_that_cannot_be_drawn_is_named(puppet_run, puppets, monkeypatch, skeleton, message):
    run = puppet_run()
    monkeypatch.setattr(puppets.Puppet, "skeleton", skeleton)
    with pytest.raises(PluginError, match=f"package gaitsim-puppets.*{message}"):
        Video(run, (), RenderSettings(**SMALL))


def flapping(frequency, frame_rate=1000.0, seconds=2.0, drift=0.3):
    """Return a body with two wings that climbs and drifts."""
    times = np.arange(0, seconds, 1 / frame_rate)
    segments = np.zeros((len(times), 2, 2, 3))
    segments[:, 0, 1, 1], segments[:, 1, 1, 1] = 0.5, -0.5
    segments[:, :, 1, 2] = 0.3 * np.sin(2 * np.pi * frequency * times)[:, None]
    segments[..., 0] += drift * times[:, None, None]
    segments[..., 2] += 4 * times[:, None, None] ** 2
    return Skeleton(segments, ("L", "R"), frame_rate, centre=segments[:, 0, 0])


@pytest.mark.parametrize("frequency", [0.8, 3.0, 12.0, 25.0, 49.0])
def test_the_frequency_is_that_of_the_wing_beat(frequency):
    assert movement_frequency(flapping(frequency, seconds=5.0)) == pytest.approx(frequency, abs=0.3)


@pytest.mark.parametrize("frames", [1, 2, 40])
def test_a_body_that_does_not_move_about_its_path_has_frequency_0(frames):
    segments = np.tile(np.eye(2, 3), (frames, 1, 1, 1)) + np.arange(frames)[:, None, None, None]
    assert movement_frequency(Skeleton(segments, ("a",), 30.0)) == 0


@pytest.mark.parametrize("rate", [10, 25, 30, 60])
@pytest.mark.parametrize("frequency", [0.0, 1.5, 3.7, 8.0, 25.0, 49.0])
def test_slow_motion_shows_each_beat_and_is_not_slower_than_needed(frequency, rate):
    speed = default_speed(frequency, rate, 0.01)
    assert is_resolved(frequency, rate, speed)
    if speed < 1:
        assert not is_resolved(frequency, rate, 1)
        assert ENOUGH <= rate / (frequency * speed) < 2 * ENOUGH


def test_no_motion_is_slower_than_allowed():
    assert default_speed(1e9, 30, 0.01) == 1 / 64
