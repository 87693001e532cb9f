"""The fly's options, their validation and derived quantities; the conditions of its world."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from gaitsim.plugin import WORLD_HELP, Condition, Organism, check_world, option
from gaitsim.plugin.toolkit import (
    ACTIVATION_CODES,
    condition_rng,
    conditions,
    cos,
    draw_joint_errors,
    draw_push,
    sin,
)
from gaitsim_fly.mechanics import Mechanics


def fly_conditions(air_density: float) -> dict[str, Condition]:
    """Return the conditions of a fly by name; `air_density` is the nominal density, kg/m³."""
    own = conditions("mass", "latency", "servo_speed", "joint_offset", "push")
    return {
        **own,
        "latency": replace(own["latency"], high=0.02),
        "air_density": Condition(
            "kg/m³",
            air_density,
            0.85 * air_density,
            1.1 * air_density,
            0.0,
            10 * air_density,
            "density of the air",
        ),
        "wind": Condition("m/s", 0.0, 0.0, 1.0, 0.0, 30.0, "steady horizontal wind"),
    }


def wing_offsets(world: Mapping[str, float], *, planar: bool) -> NDArray[np.float64]:
    """Return the constant error of each wing angle, (6,) rad.

    Args:
        world: values by the names of conditions.
        planar: whether both wings get the same errors, as wings with equal commands cannot
            correct a difference.
    """
    drawn = draw_joint_errors(world, "joint_offset", 6)
    return np.tile(drawn[:3], 2) if planar else drawn


def wind(world: Mapping[str, float], *, planar: bool) -> tuple[float, float]:
    """Return the velocity of the air along x and y, m/s; only along x if `planar`."""
    direction = 2 * math.pi * float(condition_rng(world, "wind").random())
    return _horizontal(world.get("wind", 0.0), direction, planar)


def push(
    world: Mapping[str, float], frames: int, *, planar: bool
) -> tuple[int, NDArray[np.float64]]:
    """Return the frame of a push and its change of the velocity, (3,) m/s."""
    frame, direction = draw_push(world, frames)
    return frame, np.array([*_horizontal(world.get("push", 0.0), direction, planar), 0.0])


def _horizontal(size: float, direction: float, planar: bool) -> tuple[float, float]:
    if planar:
        return math.copysign(size, cos(direction)), 0.0
    return size * float(cos(direction)), size * float(sin(direction))


Course = Literal["none", "hover", "climb", "left", "right", "forward"]
COURSES = get_args(Course)[1:]
Layer = Annotated[int, Field(ge=1, le=256)]

MOST_STEPS = 2_000_000  # simulated in all trials of an individual, in about 7 s
ControlArguments = tuple[
    NDArray[np.int64], int, NDArray[np.float64], float, int, NDArray[np.float64]
]


BODY_INPUTS = 12
"""Number of inputs before the wing angles: position, rotation, velocity and spin, 3 each."""


class FlyOptions(Organism):
    """Options of the fly, a cuboid with two triangular wings in air."""

    wings: Literal["symmetric", "asymmetric", "mirrored"] = option(
        "symmetric",
        "control of the wings: 'symmetric' moves both alike, with a network of 15 inputs "
        "and 3 outputs; 'asymmetric' moves each independently, with 18 inputs and 6 "
        "outputs; 'mirrored' moves each with its own copy of a network of 18 inputs and "
        "3 outputs, where the right wing's copy gets mirrored inputs",
    )
    hidden: tuple[Layer, ...] = option(
        (20, 20), "number of units of each hidden layer, at most four layers"
    )
    activation: Literal["tanh", "sigmoid", "relu", "leaky-relu"] = option(
        "tanh", "activation of the hidden layers; the outputs always use 'tanh'"
    )
    weight_sigma: float = option(
        0.5, "standard deviation of the initial weights and biases", gt=0, le=10
    )
    weight_limit: float = option(5.0, "largest absolute value of a weight or bias", gt=0, le=100)

    duration: float = option(3.0, "length of a flight", unit="s", ge=1e-3, le=600)
    dt: float = option(0.001, "time step of the simulation", unit="s", ge=1e-6, le=0.1)
    control_step: float = option(
        0.01, "time between commands of the network, a multiple of 'dt'", unit="s", ge=1e-6, le=10
    )
    trials: int = option(
        1,
        "number of trials: flights of each individual from different starting states",
        ge=1,
        le=100,
    )
    trial_seed: int = option(
        0, "seed of all starting states but the first, which is level and at rest", ge=0
    )
    start_offset: float = option(
        0.3, "largest starting distance from the origin along each axis", unit="m", ge=0, le=10
    )
    start_tilt: float = option(15.0, "largest starting tilt about each axis", unit="°", ge=0, le=90)
    start_speed: float = option(
        0.5, "largest starting speed along each axis", unit="m/s", ge=0, le=10
    )
    start_spin: float = option(
        1.0, "largest starting angular speed about each axis", unit="rad/s", ge=0, le=20
    )

    start_heading: float = option(
        0.0, "largest starting heading to either side", unit="°", ge=0, le=180
    )

    course: Course = option(
        "none",
        "reference of the network's inputs: 'none' is the world frame; the others are a point and "
        "a heading that, from the start of the flight, stay ('hover'), climb ('climb'), turn "
        "('left', 'right') or move forward ('forward')",
    )
    course_changes: float = option(
        0.0,
        "mean time between changes from this course to another or back, as in steering; 0 for no "
        "changes",
        unit="s",
        ge=0,
        le=600,
    )
    course_climb: float = option(0.5, "speed of the course 'climb'", unit="m/s", ge=0, le=20)
    course_turn: float = option(
        1.5, "turn rate of the courses 'left' and 'right'", unit="rad/s", ge=0, le=20
    )
    course_speed: float = option(1.5, "speed of the course 'forward'", unit="m/s", ge=0, le=20)

    mass: float = option(0.2, "mass of the body; the wings have none", unit="kg", ge=1e-6, le=100)
    length: float = option(0.3, "length of the body", unit="m", ge=1e-3, le=10)
    width: float = option(0.1, "width of the body", unit="m", ge=1e-3, le=10)
    height: float = option(0.1, "height of the body", unit="m", ge=1e-3, le=10)
    span: float = option(0.5, "span of a wing, hinge to far edge", unit="m", ge=1e-3, le=10)
    chord: float = option(0.3, "length of a wing's far edge", unit="m", ge=1e-3, le=10)
    wing_speed: float = option(
        40.0, "largest angular speed of a wing; 0 locks the wings", unit="rad/s", ge=0, le=1000
    )
    flap_limit: float = option(60.0, "largest flap, up and down", unit="°", ge=0, le=90)
    pitch_limit: float = option(80.0, "largest pitch, up and down", unit="°", ge=0, le=90)
    sweep_limit: float = option(30.0, "largest sweep, forward and backward", unit="°", ge=0, le=90)
    wing_drag: float = option(1.2, "drag coefficient of a wing normal to the flow", ge=0, le=10)
    body_drag: float = option(1.2, "drag coefficient of the body", ge=0, le=10)
    air_density: float = option(1.2, "density of the air", unit="kg/m³", ge=0, le=2000)
    gravity: float = option(9.81, "acceleration of gravity", unit="m/s²", ge=0, le=100)

    position_scale: float = option(
        2.0,
        "scale of the position inputs: the distance that becomes an input of 1",
        unit="m",
        ge=1e-3,
        le=1e6,
    )
    velocity_scale: float = option(
        5.0,
        "scale of the velocity inputs: the speed that becomes an input of 1",
        unit="m/s",
        ge=1e-3,
        le=1e6,
    )
    spin_scale: float = option(
        10.0,
        "scale of the angular velocity inputs: the angular speed that becomes an input of 1",
        unit="rad/s",
        ge=1e-3,
        le=1e6,
    )

    world: dict[str, float] = option({}, WORLD_HELP)

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_world(self.world, self.conditions())
        if len(self.hidden) > 4:
            raise ValueError(f"'hidden' has {len(self.hidden)} layers, but at most 4 are allowed")
        if not _divides(self.dt, self.control_step):
            raise ValueError(
                f"'control_step', {self.control_step:g} s, is not a multiple of 'dt', {self.dt:g} s"
            )
        if not _divides(self.control_step, self.duration):
            raise ValueError(
                f"'duration', {self.duration:g} s, is not a multiple of 'control_step', "
                f"{self.control_step:g} s"
            )
        if self.frames * self.trials > 1_000_000:
            raise ValueError(
                f"{self.trials:,} trials of {self.frames:,} commands each are too many; at most "
                "1,000,000 commands in all are allowed"
            )
        steps = self.trials * round(self.duration / self.dt)
        if steps > MOST_STEPS:
            raise ValueError(
                f"{self.trials:,} trials of {self.duration:g} s in steps of {self.dt:g} s are "
                f"{steps:,} steps, but at most {MOST_STEPS:,} are allowed"
            )
        stable = self.mechanics({}).stable_step
        if self.dt > stable:
            raise ValueError(
                f"dt {self.dt:g} s is unstable with these wings: choose at most "
                f"{math.floor(stable * 1e6) / 1e6:g} s"
            )
        return self

    @property
    def layers(self) -> tuple[int, ...]:
        """Units of each layer of the network, inputs first."""
        inputs = 15 if self.planar else 18
        return (inputs, *self.hidden, 6 if self.wings == "asymmetric" else 3)

    @property
    def frames(self) -> int:
        """Number of frames of a flight, one per command and one at its end."""
        return round(self.duration / self.control_step) + 1

    def mechanics(self, world: Mapping[str, float]) -> Mechanics:
        """Return body, wings and air in a world, given as values by the names of conditions."""
        return Mechanics(
            mass=world.get("mass", 1.0) * self.mass,
            size=(self.length, self.width, self.height),
            span=self.span,
            chord=self.chord,
            wing_speed=world.get("servo_speed", 1.0) * self.wing_speed,
            wing_drag=self.wing_drag,
            body_drag=self.body_drag,
            air_density=world.get("air_density", self.air_density),
            gravity=self.gravity,
            wind=wind(world, planar=self.planar),
        )

    def control_arguments(self, own: Mechanics) -> ControlArguments:
        """Return the arguments of the compiled flight that describe the network and the mechanics.

        Returns:
            Units of each layer; the activation's code; limits of flap, pitch and sweep, (3,) rad;
            the time step, s; time steps between commands; the constants (see `gaitsim_fly.flight`).
        """
        nominal = round(self.control_step / self.dt)
        # The time step of the options may be unstable in a denser world.
        steps = max(nominal, math.ceil(self.control_step / own.stable_step))
        return (
            np.array(self.layers),
            ACTIVATION_CODES[self.activation],
            np.radians([self.flap_limit, self.pitch_limit, self.sweep_limit]),
            self.dt if steps == nominal else self.control_step / steps,
            steps,
            self._constants(own),
        )

    def _constants(self, own: Mechanics) -> NDArray[np.float64]:
        from gaitsim_fly import flight

        c = np.empty(flight.CONSTANTS)
        own.fill(c)
        c[flight.SPEED_LIMIT] = flight.FASTEST
        c[flight.TURN_LIMIT] = flight.LARGEST_TURN
        c[flight.POSITION_SCALE] = self.position_scale
        c[flight.VELOCITY_SCALE] = self.velocity_scale
        c[flight.SPIN_SCALE] = self.spin_scale
        return c

    @property
    def planar(self) -> bool:
        """Whether both wings get the same commands, so that the fly cannot leave its plane."""
        return self.wings == "symmetric"

    def conditions(self) -> Mapping[str, Condition]:
        """Return the conditions: mass, air, wind, pushes, and errors of the wings."""
        return fly_conditions(self.air_density)

    def course_speeds(self, course: str) -> NDArray[np.float64]:
        """Return a course's speeds: forward and upwards, m/s, and turn to the left, rad/s, (3,)."""
        turns = {"left": self.course_turn, "right": -self.course_turn}
        return np.array(
            [
                self.course_speed if course == "forward" else 0.0,
                self.course_climb if course == "climb" else 0.0,
                turns.get(course, 0.0),
            ]
        )


def _divides(part: float, whole: float) -> bool:
    """Return whether `whole` is a multiple of `part`, up to rounding of floats."""
    count = whole / part
    return round(count) >= 1 and math.isclose(count, round(count), rel_tol=1e-9)
