import signal

import pytest

QUICK = ("--size", "160x120", "--fps", "2", "--no-intro")


@pytest.fixture
def run(finished):
    """A finished run of puppets."""
    finished.rename("runs/mine")
    return "mine"


def test_the_video_is_written_to_the_exports(gaitsim, run, tmp_path):
    said = gaitsim("video", run, *QUICK).stdout
    (path,) = (tmp_path / "runs" / "mine" / "exports").iterdir()
    assert path.name.startswith("video-generation-")
    assert path.suffix == ".mp4"
    assert said == f"{path.relative_to(tmp_path)}: 3 pictures of 160 × 120 at 2 per second, 1.5 s\n"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--size", "641"], "'641'"),
        (["--fps", "nan"], "1 to 120, or to 50 for a GIF"),
        (["--generations", "1,2", "--generation", "1"], "--generation and --generations cannot"),
    ],
)
def test_an_invalid_option_is_one_message(gaitsim, run, tmp_path, arguments, says):
    before = sorted(tmp_path.rglob("*"))
    error = gaitsim("video", run, *arguments, code=2).stderr
    assert says in error.replace("\n", " ")
    assert "Traceback" not in error
    after = [path for path in tmp_path.rglob("*") if path.name != "exports"]
    assert sorted(after) == [path for path in before if path.name != "exports"]


def test_ctrl_c_leaves_no_file(gaitsim, run, tmp_path, monkeypatch):
    from gaitsim.render.scene import Scene

    draw = Scene.draw

    def interrupted(self, seconds, turned=0.0):
        if seconds > 0.3:
            signal.raise_signal(signal.SIGINT)
        return draw(self, seconds, turned)

    monkeypatch.setattr(Scene, "draw", interrupted)
    said = gaitsim("video", run, *QUICK, "--out", "a.mp4", code=130)
    assert "Stopped; nothing was written." in said.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"puppet.toml", "runs"}
