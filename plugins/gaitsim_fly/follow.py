"""The fitness `follow-course`, which rewards following a course, upright and facing ahead."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, option
from gaitsim.portable import cos, norm, sin


class FollowCourse(Fitness):
    """Nearness to the course, minus a loss for leaning or pointing away from the heading.

    The score is a product, so it is low for a fly that falls upright and for a fly that tumbles in
    place. A fly that follows its course perfectly scores 1.
    """

    radius: float = option(
        0.5,
        "distance from the course at which the term 'nearness' is half its maximum",
        unit="m",
        gt=0,
        le=100,
    )

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("position", "rotation", "course")

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return nearness and loss, as means over time and trials.

        Nearness is radius / (radius + distance). The loss leaves the share (1 + u)/2 · (1 + a)/2
        of it, where u and a are the cosines of the angles between the back and the vertical and
        between the nose and the heading.
        """
        course = motion["course"]
        away = norm(motion["position"] - course[..., :3])
        nearness = self.radius / (self.radius + away)
        w, x, y, z = np.moveaxis(motion["rotation"], -1, 0)
        ahead = (1 - 2 * (y * y + z * z)) * cos(course[..., 3])
        ahead = ahead + 2 * (x * y + w * z) * sin(course[..., 3])
        upright = 1 - 2 * (x * x + y * y)
        lost = nearness * ((1 + upright) * (1 + ahead) / 4 - 1)
        # The order of sums depends on the memory layout, and that of over 8,192 numbers on NumPy's
        # version; hence one axis after the other.
        return {
            name: np.ascontiguousarray(values.swapaxes(1, 2)).mean(axis=2).mean(axis=1)
            for name, values in (("nearness", nearness), ("attitude", lost))
        }
