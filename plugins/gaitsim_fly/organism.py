"""The fly: a rigid body with two wings, steered by a network."""

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from gaitsim.contracts import (
    WORLD_HELP,
    Array,
    Channel,
    Condition,
    Genomes,
    Measure,
    Motion,
    Organism,
    RealSpace,
    Skeleton,
    check_world,
    option,
)
from gaitsim.network import ACTIVATION_CODES, gene_labels
from gaitsim_fly import body
from gaitsim_fly.conditions import fly_conditions, push, wind, wing_offsets
from gaitsim_fly.measures import measures
from gaitsim_fly.mechanics import Mechanics
from gaitsim_fly.skeleton import skeleton
from gaitsim_fly.starts import starts

Layer = Annotated[int, Field(ge=1, le=256)]

MOST_STEPS = 2_000_000  # of the simulation, in all trials: about 7 s an individual
STARTS = ("frames", "trials")
XYZ = ("x", "y", "z")
WINGS = ("left flap", "left pitch", "left sweep", "right flap", "right pitch", "right sweep")


class Fly(Organism):
    """A cuboid with two triangular wings in still air; a network commands the wings."""

    wings: Literal["symmetric", "asymmetric"] = option(
        "symmetric",
        "whether both wings do the same or each its own: 15 inputs, 3 outputs, or 18, 6",
    )
    hidden: tuple[Layer, ...] = option((20, 20), "units of each hidden layer, at most four layers")
    activation: Literal["tanh", "sigmoid", "relu", "leaky-relu"] = option(
        "tanh", "activation of the hidden layers; the outputs always go through tanh"
    )
    weight_sigma: float = option(
        0.5, "standard deviation of the first weights and biases", gt=0, le=10
    )
    weight_limit: float = option(5.0, "largest weight and bias", gt=0, le=100)

    duration: float = option(3.0, "length of a flight", unit="s", ge=1e-3, le=600)
    dt: float = option(0.001, "time step of the simulation", unit="s", ge=1e-6, le=0.1)
    control_step: float = option(
        0.01, "time between two commands of the network, a multiple of dt", unit="s", ge=1e-6, le=10
    )
    trials: int = option(1, "flights of each individual, from as many start states", ge=1, le=100)
    trial_seed: int = option(0, "seed of the start states but the first, at rest", ge=0)
    start_offset: float = option(
        0.3, "largest distance of a start from the origin along each axis", unit="m", ge=0, le=10
    )
    start_tilt: float = option(
        15.0, "largest turn of a start about each axis", unit="°", ge=0, le=90
    )
    start_speed: float = option(
        0.5, "largest speed of a start along each axis", unit="m/s", ge=0, le=10
    )
    start_spin: float = option(
        1.0, "largest angular speed of a start about each axis", unit="rad/s", ge=0, le=20
    )

    mass: float = option(0.2, "mass, all of it in the body", unit="kg", ge=1e-6, le=100)
    length: float = option(0.3, "length of the body", unit="m", ge=1e-3, le=10)
    width: float = option(0.1, "width of the body", unit="m", ge=1e-3, le=10)
    height: float = option(0.1, "height of the body", unit="m", ge=1e-3, le=10)
    span: float = option(0.5, "span of a wing, hinge to far edge", unit="m", ge=1e-3, le=10)
    chord: float = option(0.3, "far edge of a wing's triangle", unit="m", ge=1e-3, le=10)
    wing_speed: float = option(
        40.0, "largest angular speed of a wing; 0 locks them", unit="rad/s", ge=0, le=1000
    )
    flap_limit: float = option(60.0, "largest flap, up and down", unit="°", ge=0, le=90)
    pitch_limit: float = option(80.0, "largest pitch, either way", unit="°", ge=0, le=90)
    sweep_limit: float = option(30.0, "largest sweep, to front and back", unit="°", ge=0, le=90)
    wing_drag: float = option(1.2, "drag coefficient of a wing face on", ge=0, le=10)
    body_drag: float = option(1.2, "drag coefficient of the body", ge=0, le=10)
    air_density: float = option(1.2, "density of the air", unit="kg/m³", ge=0, le=2000)
    gravity: float = option(9.81, "acceleration of gravity", unit="m/s²", ge=0, le=100)

    position_scale: float = option(
        2.0, "distance that the network sees as 1, the most that it sees", unit="m", ge=1e-3, le=1e6
    )
    velocity_scale: float = option(
        5.0, "speed that the network sees as 1, the most that it sees", unit="m/s", ge=1e-3, le=1e6
    )
    spin_scale: float = option(
        10.0,
        "angular speed that the network sees as 1, the most that it sees",
        unit="rad/s",
        ge=1e-3,
        le=1e6,
    )

    threads: ClassVar[bool] = True
    dynamic: ClassVar[bool] = True
    channels: ClassVar[Mapping[str, Channel]] = {
        "position": Channel((*STARTS, XYZ), "m", "centre of mass; z is up"),
        "altitude": Channel(STARTS, "m", "z of the position"),
        "rotation": Channel((*STARTS, ("w", "x", "y", "z")), "", "unit quaternion of the body"),
        "velocity": Channel((*STARTS, XYZ), "m/s", "in the world"),
        "angular_velocity": Channel((*STARTS, XYZ), "rad/s", "in the world"),
        "wing_angles": Channel((*STARTS, WINGS), "rad", "angles of the wings"),
    }

    world: dict[str, float] = option({}, WORLD_HELP)

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_world(self.world, self.conditions())
        if len(self.hidden) > 4:
            raise ValueError(f"hidden has {len(self.hidden)} layers, at most four are allowed")
        if not _divides(self.dt, self.control_step):
            raise ValueError(
                f"control_step {self.control_step:g} s is not a multiple of dt {self.dt:g} s"
            )
        if not _divides(self.control_step, self.duration):
            raise ValueError(
                f"duration {self.duration:g} s is not a multiple of control_step "
                f"{self.control_step:g} s"
            )
        if self.frames * self.trials > 1_000_000:
            raise ValueError(
                f"{self.trials:,} trials of {self.frames:,} commands are more than a million"
            )
        steps = self.trials * round(self.duration / self.dt)
        if steps > MOST_STEPS:
            raise ValueError(
                f"{self.trials:,} trials of {self.duration:g} s in steps of {self.dt:g} s are "
                f"{steps:,} steps, at most {MOST_STEPS:,} are allowed"
            )
        stable = self.mechanics({}).stable_step
        if self.dt > stable:
            raise ValueError(
                f"dt {self.dt:g} s is not stable with these wings: at most "
                f"{math.floor(stable * 1e6) / 1e6:g} s"
            )
        return self

    @property
    def layers(self) -> tuple[int, ...]:
        """Units of each layer of the network, inputs first."""
        each = 3 if self.wings == "symmetric" else 6
        return (12 + each, *self.hidden, each)

    @property
    def frames(self) -> int:
        """Number of commands in a flight, its end included."""
        return round(self.duration / self.control_step) + 1

    def mechanics(self, world: Mapping[str, float]) -> Mechanics:
        """Return mass, air and wings in a world, by the names of conditions."""
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
            wind=wind(world, planar=self._planar),
        )

    @property
    def _planar(self) -> bool:
        return self.wings == "symmetric"

    def conditions(self) -> Mapping[str, Condition]:
        """What may vary: mass, air, wind, pushes, and how the wings follow their commands."""
        return fly_conditions(self.air_density)

    def genome_space(self) -> RealSpace:
        """A gene a weight and bias: W1 row by row, b1, W2, b2 …"""
        labels = gene_labels(self.layers)
        limit = np.full(len(labels), self.weight_limit)
        return RealSpace(-limit, limit, labels, np.full(len(labels), self.weight_sigma))

    def starts(self) -> NDArray[np.float64]:
        """State at the start of each trial, (trials, STATE), see `gaitsim_fly.flight`."""
        return starts(
            self.trials,
            self.trial_seed,
            self.mechanics(self.world).inertia,
            offset=self.start_offset,
            tilt=math.radians(self.start_tilt),
            speed=self.start_speed,
            spin=self.start_spin,
            planar=self._planar,
        )

    def move(self, genomes: Genomes) -> Motion:
        """Fly every trial of every individual."""
        from gaitsim_fly import flight
        from gaitsim_fly.control import fly

        own, interval = self.mechanics(self.world), self.control_step
        nominal = round(interval / self.dt)
        # A world may make the time step of the options unstable.
        steps = max(nominal, math.ceil(interval / own.stable_step))
        population, lanes = len(genomes), len(genomes) * self.trials
        states = np.empty((lanes, self.frames, flight.STATE))
        angles = np.empty((lanes, self.frames, 6))
        lasted = np.empty(lanes, dtype=np.int64)
        fly(
            np.ascontiguousarray(genomes, dtype=np.float64),
            np.array(self.layers),
            ACTIVATION_CODES[self.activation],
            self.starts(),
            np.radians([self.flap_limit, self.pitch_limit, self.sweep_limit]),
            self.dt if steps == nominal else interval / steps,
            steps,
            self._constants(own),
            wing_offsets(self.world, planar=self._planar),
            self.world.get("latency", 0.0) / interval,
            *push(self.world, self.frames, planar=self._planar),
            states,
            angles,
            lasted,
        )

        def by_trial(values: Array) -> Array:
            """(lanes, frames, …) -> (population, frames, trials, …)."""
            return values.reshape(population, self.trials, *values.shape[1:]).swapaxes(1, 2)

        position = by_trial(states[..., flight.POSITION : flight.POSITION + 3])
        rotation = by_trial(states[..., flight.ROTATION : flight.ROTATION + 4])

        def angular_velocity() -> dict[str, Array]:
            turn = body.rotation(rotation)[..., :3, :3]
            momentum = by_trial(states[..., flight.MOMENTUM : flight.MOMENTUM + 3])
            spin = np.einsum("...ji,...j->...i", turn, momentum) / own.inertia
            return {"angular_velocity": np.einsum("...ij,...j->...i", turn, spin)}

        return Motion(
            1 / self.control_step,
            {
                "position": position,
                "altitude": position[..., 2],
                "rotation": rotation,
                "velocity": by_trial(states[..., flight.VELOCITY : flight.VELOCITY + 3]),
                "wing_angles": by_trial(angles),
            },
            {("angular_velocity",): angular_velocity},
            failures=self._failures(lasted),
        )

    def _failures(self, lasted: NDArray[np.int64]) -> dict[int, str]:
        """Return the reasons of unstable flights, by individual."""
        failures = {}
        for lane in np.flatnonzero(lasted < self.frames)[::-1].tolist():  # the first trial counts
            individual, trial = divmod(lane, self.trials)
            failures[individual] = (
                f"its flight became unstable within {lasted[lane] * self.control_step:.4g} s"
                + (f" in trial {trial + 1}" if self.trials > 1 else "")
                + f"; a dt below {self.dt:g} s may follow it"
            )
        return failures

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

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Altitude, horizontal distance, tilt and wing beat; means over the trials."""
        return measures(motion)

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Body and wings in the world, in the first trial."""
        size = (self.length, self.width, self.height)
        return skeleton(motion, individual, size, self.span, self.chord)


def _divides(part: float, whole: float) -> bool:
    """Return whether `whole` is a multiple of `part`, up to rounding of floats."""
    count = whole / part
    return round(count) >= 1 and math.isclose(count, round(count), rel_tol=1e-9)
