"""The fitness `follow-course`: stay with a course, upright and along its heading."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, option


class FollowCourse(Fitness):
    """Nearness to the course, less what a fly loses that leans or looks another way.

    A product, so that neither a fly that falls upright nor one that tumbles in place scores. A fly
    that follows its course perfectly scores 1.
    """

    radius: float = option(
        0.5, "distance from the course that halves the nearness", unit="m", gt=0, le=100
    )

    needs: ClassVar[tuple[str, ...]] = ("position", "rotation", "course")

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Nearness radius / (radius + distance), and its loss; means over time and trials.

        Of the nearness remains the share (1 + u)/2 · (1 + a)/2, where u and a are the cosines of
        the angles from the back to the vertical and from the nose to the heading.
        """
        course = motion["course"]
        away = np.linalg.norm(motion["position"] - course[..., :3], axis=-1)
        nearness = self.radius / (self.radius + away)
        w, x, y, z = np.moveaxis(motion["rotation"], -1, 0)
        ahead = (1 - 2 * (y * y + z * z)) * np.cos(course[..., 3])
        ahead = ahead + 2 * (x * y + w * z) * np.sin(course[..., 3])
        upright = 1 - 2 * (x * x + y * y)
        lost = nearness * ((1 + upright) * (1 + ahead) / 4 - 1)
        return {"nearness": nearness.mean(axis=(1, 2)), "attitude": lost.mean(axis=(1, 2))}
