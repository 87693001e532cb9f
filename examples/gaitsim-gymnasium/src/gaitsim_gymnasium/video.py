"""Videos by the environment's own renderer."""

import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from gaitsim.plugin import Array, Exported, Exporter, GaitsimError, Subject, option

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Individual
    from gaitsim_gymnasium import Environment


class EnvironmentVideo(Exporter):
    """A video of an episode, drawn by the environment itself."""

    title: ClassVar[str] = "Video by Gymnasium"
    group: ClassVar[str] = "Videos"
    suffix: ClassVar[str] = ".mp4"
    stem: ClassVar[str] = "episode"
    items: ClassVar[str] = "pictures"

    seconds: float | None = option(
        None,
        "length of the video, from the start of the episode",
        unset="the whole episode",
        unit="s",
        gt=0,
        le=100_000,
    )

    def check(self, individual: "Individual") -> None:
        """Check that the body is an environment of Gymnasium."""
        _body(individual)

    def write(self, subject: Subject, path: Path) -> Exported:
        """Repeat the actions of the individual in an environment that draws, and write the file."""
        from imageio.v3 import imopen

        if path.suffix.lower() != self.suffix:
            raise GaitsimError(f"unknown extension for videos: {path}", allowed=self.suffix)
        body, motion = _body(subject.individual), subject.individual.motion
        limits = body.limits
        seconds = min(float(motion["lasted"][0]), self.seconds or np.inf)
        actions = motion["action"][0, 1 : round(seconds * limits.frame_rate) + 1]
        subject.begin(len(actions) + 1)
        part = path.with_name(f".{path.name}.part{path.suffix}")
        try:
            with imopen(part, "w", plugin="pyav") as file:
                file.init_video_stream("libx264", fps=limits.frame_rate, pixel_format="yuv420p")
                for picture in _pictures(body, actions):
                    file.write_frame(picture)
                    subject.advance(1)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
        return Exported(f"{len(actions) + 1} frames at {limits.frame_rate:g} Hz")


def _body(individual: "Individual") -> "Environment":
    from gaitsim_gymnasium import Environment

    body = individual.experiment.organism
    if not isinstance(body, Environment):
        raise GaitsimError(
            "the body is not an environment of Gymnasium",
            where="--format",
            allowed="a run of the body 'gymnasium'",
        )
    return body


def _pictures(body: "Environment", actions: Array) -> Iterator[Array]:
    """Yield the picture before the first action, and after each, (height, width, 3)."""
    from gaitsim_gymnasium.environments import create

    if sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & {*os.environ}:
        os.environ.setdefault("MUJOCO_GL", "egl")  # draws without a display
    robot = create(body.env, render_mode="rgb_array")
    _follow(robot.unwrapped)
    try:
        robot.reset(seed=int(body.world.get("seed", 0)))
        for action in [None, *actions]:
            if action is not None:
                robot.step(body.limits.shaped(action))
            picture = np.asarray(robot.render())
            height, width = picture.shape[:2]
            yield picture[: height - height % 2, : width - width % 2]  # as H.264 needs
    except Exception as error:  # a renderer may lack a display, a driver or a package
        raise GaitsimError(
            f"the environment cannot draw itself: {type(error).__name__}: {error}",
            where="--format gymnasium-video",
            remedy="install what the message names; for robots in MuJoCo without a display, set "
            "MUJOCO_GL=egl or MUJOCO_GL=osmesa",
        ) from None
    finally:
        robot.close()


def _follow(robot: Any) -> None:
    """Follow a robot in MuJoCo that has a camera for this; Gymnasium's camera may stand still."""
    with suppress(AttributeError, KeyError):
        robot.mujoco_renderer.camera_id = robot.model.camera("track").id
