"""Videos by the environment's own renderer."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from gaitsim.contracts import Exported, Exporter, Subject
from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.individual import Individual


class EnvironmentVideo(Exporter):
    """A video of an episode, drawn by the environment itself."""

    title: ClassVar[str] = "Video by Gymnasium"
    group: ClassVar[str] = "Videos"
    suffix: ClassVar[str] = ".mp4"
    stem: ClassVar[str] = "episode"

    def check(self, individual: "Individual") -> None:
        """Check that the body is an environment of Gymnasium."""
        from gaitsim_gymnasium import Environment

        if not isinstance(individual.experiment.organism, Environment):
            raise GaitsimError(
                "the body is not an environment of Gymnasium",
                where="--format",
                allowed="a run of the body 'gymnasium'",
            )

    def write(self, subject: Subject, path: Path) -> Exported:
        """Repeat the actions of the individual in an environment that draws, and write the file."""
        import imageio

        from gaitsim_gymnasium.environments import create

        individual = subject.individual
        body = individual.experiment.organism
        limits, motion = body.limits, individual.motion
        count = round(float(motion["lasted"][0]) * limits.frame_rate)
        robot = create(body.env, render_mode="rgb_array")
        try:
            robot.reset(seed=int(body.world.get("seed", 0)))
            pictures = [robot.render()]
            for action in motion["action"][0, 1 : count + 1]:
                robot.step(limits.shaped(action))
                pictures.append(robot.render())
        except Exception as error:  # a renderer may lack a display, a driver or a package
            raise GaitsimError(
                f"the environment cannot draw itself: {type(error).__name__}: {error}",
                where="--format gymnasium-video",
                remedy="without a display, set MUJOCO_GL=egl or MUJOCO_GL=osmesa",
            ) from None
        finally:
            robot.close()
        frames: list[Any] = [
            np.asarray(picture)[: h - h % 2, : w - w % 2]
            for picture in pictures
            for h, w in [np.shape(picture)[:2]]
        ]
        part = path.with_name(f".{path.name}.part{path.suffix}")
        imageio.mimsave(part, frames, fps=limits.frame_rate, macro_block_size=1)
        part.replace(path)
        return Exported(f"{len(frames)} frames at {limits.frame_rate:g} Hz")
