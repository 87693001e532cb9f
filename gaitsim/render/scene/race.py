"""Several bodies in lanes on one ground, and the aim of the camera."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gaitsim.render.scene.camera import Points
from gaitsim.render.scene.clip import Clip, Pose

MOMENTS = 100  # number of moments at which the bodies are measured
LANE_GAP = 0.15  # gap between bodies side by side, in body widths
MIN_LANE = 0.7  # minimum distance of lanes, in body heights, so that thin bodies hide no others
MAX_LANE = (
    3.0  # maximum width of a lane, in body widths; bodies that drift farther leave their lane
)


class Race:
    """One body, or several in lanes, of which the first is the farthest from the camera.

    Args:
        clips: bodies in motion.
        leader: index of the clip that stays visible when the bodies are too far apart to show all.

    Attributes:
        clips: the clips in their lanes, on a common ground.
        room: maximum distance of the leader from the aim of the camera, m.
    """

    def __init__(self, clips: Sequence[Clip], leader: int) -> None:
        self.clips = _in_lanes(clips) if len(clips) > 1 else list(clips)
        self.leader, self.room = leader, np.inf
        self.seconds = max(clip.seconds for clip in clips)
        self.span = max(clip.anatomy.span for clip in clips)

    def aim(self, poses: Sequence[Pose]) -> Points:
        """Return the aim of the camera: the middle of the bodies, but near the leader."""
        aims = np.stack([pose.aim for pose in poses])
        middle = (aims.min(axis=0) + aims.max(axis=0)) / 2
        away = aims[self.leader] - middle
        far = float(np.linalg.norm(away))
        return np.asarray(middle + away * (1 - self.room / far) if far > self.room else middle)

    @property
    def box(self) -> Points:
        """The points of all bodies relative to the aim of the camera, (points, 3) m."""
        if len(self.clips) == 1:
            return self.clips[0].box
        points = []
        for seconds in np.linspace(0, self.seconds, MOMENTS):
            poses = [clip.at(seconds) for clip in self.clips]
            every = [clip.points(pose) for clip, pose in zip(self.clips, poses, strict=True)]
            points.append(np.concatenate(every) - self.aim(poses))
        return np.concatenate(points)


def _in_lanes(clips: Sequence[Clip]) -> list[Clip]:
    """Return the clips side by side, at the distances that their movement requires."""
    floor = min(clip.floor for clip in clips)
    wide, tall = np.max([np.ptp(clip.box, axis=0)[1:] for clip in clips], axis=0)
    moments = np.linspace(0, max(clip.seconds for clip in clips), MOMENTS)
    # Right and left edge of each body at each moment, (clips, moments).
    across = [[clip.points(clip.at(time))[:, 1] for time in moments] for clip in clips]
    right = np.array([[y.min() for y in clip] for clip in across])
    left = np.array([[y.max() for y in clip] for clip in across])
    lanes = [0.0]
    for farther, nearer in zip(right[:-1], left[1:], strict=True):
        step = float((nearer - farther).max()) + LANE_GAP * wide
        lanes.append(lanes[-1] - max(min(step, MAX_LANE * wide), MIN_LANE * tall))
    middle = (lanes[0] + lanes[-1]) / 2
    return [
        replace(clip, lane=lane - middle, depth=floor)
        for clip, lane in zip(clips, lanes, strict=True)
    ]
