"""The fly's body, wings and air in a world, and quantities derived from them."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Mechanics:
    """A body with two wings in the air.

    Attributes:
        mass: mass of the body, kg.
        size: length, width and height of the body, m.
        span: span of a wing, m.
        chord: chord of a wing, m.
        wing_speed: largest angular speed of a wing, rad/s.
        wing_drag: drag coefficient of a wing normal to the flow.
        body_drag: drag coefficient of the body.
        air_density: density of the air, kg/m³.
        gravity: acceleration of gravity, m/s².
        wind: velocity of the air along x and y, m/s.
    """

    mass: float
    size: tuple[float, float, float]
    span: float
    chord: float
    wing_speed: float
    wing_drag: float
    body_drag: float
    air_density: float
    gravity: float
    wind: tuple[float, float]

    @property
    def inertia(self) -> NDArray[np.float64]:
        """Principal moments of inertia of the cuboid, (3,) kg·m²."""
        square = np.square(self.size)
        moments: NDArray[np.float64] = self.mass / 12 * (square.sum() - square)
        return moments

    @property
    def stable_step(self) -> float:
        """Longest time step, s, that is stable with the wings at full speed.

        The midpoint rule is stable while the step times the rate of decay is below 2. Rotation
        about the axis of least inertia decays fastest, with both wings at their largest speed:
        torque per spin 2 · 2 (½ ρ C_D A) v r².
        """
        arm = 2 / 3 * self.span
        speed = math.sqrt(2) * arm * self.wing_speed
        reach = self.size[1] / 2 + arm
        rate = 4 * self._wing_load * speed * reach * reach / float(self.inertia.min())
        return 2 / rate if rate > 0 else math.inf

    @property
    def _wing_load(self) -> float:
        """½ ρ C_D A of a wing, kg/m."""
        return 0.5 * self.air_density * self.wing_drag * (self.span * self.chord / 2)

    def fill(self, c: NDArray[np.float64]) -> None:
        """Write the mechanical constants to the array for the compiled code, (CONSTANTS,)."""
        from gaitsim_fly import flight

        length, width, height = self.size
        c[flight.INVERSE_MASS] = 1 / self.mass
        c[flight.GRAVITY] = self.gravity
        c[flight.INVERSE_INERTIA_X : flight.INVERSE_INERTIA_Z + 1] = 1 / self.inertia
        faces = np.array([width * height, length * height, length * width])
        c[flight.BODY_X : flight.BODY_Z + 1] = 0.5 * self.air_density * self.body_drag * faces
        c[flight.WING] = self._wing_load
        c[flight.HINGE] = width / 2
        c[flight.ARM] = 2 / 3 * self.span
        c[flight.WING_SPEED] = self.wing_speed
        c[flight.WIND_X], c[flight.WIND_Y] = self.wind
