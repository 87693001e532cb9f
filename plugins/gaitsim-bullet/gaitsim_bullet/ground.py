"""Level ground with Coulomb friction for a robot in PyBullet.

PyBullet limits friction along x and y to a square or to a cone. The square makes friction up to
41 % stronger along its diagonals. The cone has the right strength, but the wrong direction:
PyBullet weights both components with the effective masses of the contact, so that friction points
up to 35° away from the direction against the slip. Therefore each link has its own plane, whose
square shrinks to a rectangle with a corner where Coulomb's law puts the friction. The rectangle
follows from the force and the slip in the previous step.

Source of the law as a projection on the friction disc: G. De Saxcé, Z.-Q. Feng, The bipotential
method, Mathematical and Computer Modelling 28 (1998) 225-245.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from gaitsim_bullet.client import Client

BASE = -1
"""Index of the trunk among the links."""

LEAST = 0.02  # smallest side of the rectangle, as a share of the friction; 0 is singular


class GroundContact(NamedTuple):
    """The contact of a link with the ground.

    Attributes:
        force: force on the link, N.
        slip: velocity of the link along the ground, at the centre of pressure, m/s.
    """

    force: tuple[float, float, float]
    slip: tuple[float, float]


class FlatGround:
    """The ground z = 0 of a robot.

    Args:
        client: world with the robot.
        robot: number of the robot in the client.
        frictions: coefficient of friction of each link that may touch the ground, by its index.
        links: number of links except the trunk.
        resistance: friction for each m/s of slip that would stop a foot in about a step, N s/m.
    """

    def __init__(
        self,
        client: Client,
        robot: int,
        frictions: Mapping[int, float],
        links: int,
        resistance: float,
    ) -> None:
        self._client, self._robot, self._frictions = client, robot, frictions
        self._resistance = resistance
        self._planes: dict[int, int] = {}
        shape = client.createCollisionShape(client.GEOM_PLANE, planeNormal=[0, 0, 1])
        for link in frictions:
            plane = client.createMultiBody(0, shape)
            self._planes[plane] = link
            # Bullet multiplies the frictions of both bodies, whereas MuJoCo uses the larger one.
            client.changeDynamics(plane, BASE, lateralFriction=1.0)
            for other in range(BASE, links):
                client.setCollisionFilterPair(robot, plane, other, BASE, int(other == link))

    def touches(self, link: int) -> bool:
        """Return whether a link touches the ground."""
        return any(
            self._planes.get(point[2]) == link and point[8] <= 0
            for point in self._client.getContactPoints(self._robot)
        )

    def contacts(self) -> dict[int, GroundContact]:
        """Return the contacts in the last step by the index of the link.

        Also limits the friction in the next step, so it must be called after each step.
        """
        near: dict[int, list[Any]] = {}
        for point in self._client.getContactPoints(self._robot):
            if point[2] in self._planes:
                near.setdefault(point[2], []).append(point)
        found = {}
        for plane, points in near.items():
            link = self._planes[plane]
            contact = self._contact(link, points)
            self._client.changeDynamics(
                plane, BASE, anisotropicFriction=[*self._rectangle(link, contact), 1.0]
            )
            if contact.force[2] > 0:
                found[link] = contact
        return found

    def _contact(self, link: int, points: list[Any]) -> GroundContact:
        """Return the contact of a link, whose points of contact PyBullet returned."""
        client, robot = self._client, self._robot
        if link == BASE:
            centre = client.getBasePositionAndOrientation(robot)[0]
            speed, spin = client.getBaseVelocity(robot)
        else:
            state = client.getLinkState(robot, link, computeLinkVelocity=1)
            centre, speed, spin = state[0], state[6], state[7]
        load = sum(point[9] for point in points)
        # A foot that is about to touch the ground has points without load.
        shares = [point[9] / load if load > 0 else 1 / len(points) for point in points]
        force_x, force_y = (
            sum(point[10] * point[11][axis] + point[12] * point[13][axis] for point in points)
            for axis in range(2)
        )
        x, y, z = (
            sum(share * point[5][axis] for share, point in zip(shares, points, strict=True))
            - centre[axis]
            for axis in range(3)
        )
        # numpy.cross takes longer than all the rest.
        slip_x = speed[0] + spin[1] * z - spin[2] * y
        slip_y = speed[1] + spin[2] * x - spin[0] * z
        return GroundContact((force_x, force_y, load), (slip_x, slip_y))

    def _rectangle(self, link: int, contact: GroundContact) -> tuple[float, float]:
        """Return the sides of the rectangle relative to the square, for Coulomb's law.

        The friction is the point of the disc of possible frictions nearest to the last friction
        minus the resistance to the slip (De Saxcé & Feng). The rectangle has a corner there if the
        foot slips; if it does not, each component may grow up to the edge of the disc.
        """
        force_x, force_y, load = contact.force
        x = force_x - self._resistance * contact.slip[0]
        y = force_y - self._resistance * contact.slip[1]
        square = max(x * x + y * y, (self._frictions[link] * load) ** 2) or 1.0
        side_x, side_y = (
            max(LEAST, math.sqrt(max(0.0, 1 - across * across / square))) for across in (y, x)
        )
        return side_x, side_y
