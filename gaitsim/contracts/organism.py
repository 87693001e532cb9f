"""The contract of a body."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from gaitsim.contracts.conditions import Condition
from gaitsim.contracts.dimensions import Dimension
from gaitsim.contracts.motion import Array, Channel, Measure, Motion, Skeleton
from gaitsim.contracts.plugin import Plugin
from gaitsim.contracts.reflex import Controller
from gaitsim.contracts.rig import Rig
from gaitsim.contracts.space import Genomes, GenomeSpace
from gaitsim.contracts.steering import Command, Steered
from gaitsim.errors import GaitsimError

Facts = Mapping[str, Mapping[str, str]]
"""Facts to display: values by name, grouped under headings. A value may be ''."""


@dataclass(frozen=True)
class BodyFile:
    """A body that was read from a file.

    Attributes:
        name: name of the body.
        text: content that the option stores in place of the file's path.
        repairs: lines that list what was dropped, replaced, added or assumed when the file was
            read.
        warnings: likely mistakes in the file, each with a remedy.
    """

    name: str
    text: str
    repairs: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Question:
    """A guess about a body's file, as a question that an option answers.

    Attributes:
        text: question whether the guess is right.
        option: name of the body's option that answers it.
        value: value of the option, as for `--set`, that confirms the guess or, if that is
            impossible, a likely correction.
    """

    text: str
    option: str
    value: str


@dataclass(frozen=True, eq=False)
class FittedGait:
    """The gait of a body that is closest to given joint angles.

    Attributes:
        options: options of the body with which the genome plays the gait, by name.
        genome: genome, (genes,).
        joint_angles: its angles in the given frames, (frames, joints) rad.
    """

    options: Mapping[str, Any]
    genome: Array
    joint_angles: Array


class Organism(Plugin):
    """A body and the encoding that turns a genome into movement.

    Attributes:
        channels: channels of the body's motion by name. To be playable on a robot, a body has the
            channel `joint_angles`, `Channel(("frames", "joints"), "rad", …)`, and returns the
            names of its joints in `joint_names()`.
        threads: whether `move` and the evaluation release the global interpreter lock most of the
            time, as compiled kernels can. If so, chunks of a population are evaluated in threads,
            otherwise in processes. Keep False for a body written in pure Python.
        dynamic: whether the body is simulated with forces, so that it falls without support. For
            such a body, moments without a foot on the ground are part of a gait; for a body without
            inertia, they are signs of an exploit.
        twin: preset of the same body in rigid-body physics. Its joints have the same names and
            zeros, so that it can play this body's gaits. The default '' means that there is none.
    """

    channels: ClassVar[Mapping[str, Channel]]
    threads: ClassVar[bool] = False
    dynamic: ClassVar[bool] = False
    twin: ClassVar[str] = ""

    @abstractmethod
    def genome_space(self) -> GenomeSpace:
        """Return the genome space of this body with its options."""

    def starts(self) -> Mapping[str, Array]:
        """Return start points by name, such as 'tetrapod', the most promising first; {} by default.

        A start point is a genome (genes,) in the body's space from which a search may begin, such
        as a gait made by hand. It need not score well, only better than random genomes.
        """
        return {}

    def unfold(self, genomes: Genomes) -> Genomes | None:
        """Return the genomes of the same gaits for this body without its option `symmetry`.

        They are repaired by the caller. None, by default, for a body without symmetry.
        """
        return None

    @abstractmethod
    def move(self, genomes: Genomes) -> Motion:
        """Return the motion of a whole population, given its genomes, (population, genes).

        The motion of each individual must depend on its own genome alone, and be bit-identical
        however the population is split into chunks.
        """

    def physics_engine(self) -> str:
        """Return the package that simulates the body, such as 'mujoco'; '' without an engine.

        The results of an engine hold for one of its versions and one kind of processor.
        """
        return ""

    def play(self, joint_angles: Array) -> Motion:
        """Return the motion of a population with given joint angles, such as those from a file.

        Optional, for bodies with the channel `joint_angles` that can follow given angles.
        `measures`, `skeleton` and fitnesses must accept the motion like one from `move`.

        Args:
            joint_angles: angles to play, (population, frames, joints), radians. The body must not
                change the array.

        Returns:
            The motion. Its channel `joint_angles` contains the angles as played, within the body's
            limits of angle and speed.

        Raises:
            GaitsimError: the body cannot play joint angles.
        """
        raise GaitsimError(
            f"the body {type(self).__name__} cannot play joint angles",
            allowed="a body with the method play()",
        )

    @property
    def can_play(self) -> bool:
        """Whether the body defines `play`."""
        return type(self).play is not Organism.play

    @abstractmethod
    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return the geometry of one individual, for drawing.

        If the motion has several trials, return the geometry of the first trial.
        """

    def rig(self) -> Rig | None:
        """Return the body as a tree of links that its joint angles move; None by default.

        The page of an atlas shows gaits only if the body has a rig: it stores them as joint angles,
        and computes their 3D motion. The rig's segments, solids and feet are the skeleton's
        segments, solids and contacts, in the same order.
        """
        return None

    def urdf(self) -> str:
        """Return the undamaged body as URDF, for ROS and other programs; '' by default.

        Its movable joints have the names of `joint_names`, and the same zero and direction.
        """
        return ""

    def mjcf(self) -> str:
        """Return the undamaged body as MJCF, for MuJoCo; '' by default."""
        return ""

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return quantities that describe each motion, by name; {} by default.

        `gaitsim analyse` uses the following instead of its own, so they must mean the same: the
        displacements `forward`, `lateral` and `climb` over the whole motion, the rotation `yaw`,
        the `slip ratio` (distance that the stance feet slide, divided by the length of the path),
        `cost of transport` and `lasted` (time before a fall). The same holds for the channels
        `margin` (static stability margin) and `stride_frequency` (commanded strides per second, 0
        if unknown).
        """
        return {}

    def conditions(self) -> Mapping[str, Condition]:
        """Return the conditions that may vary between worlds, by name; {} by default.

        A body with conditions has the option `world: dict[str, float] = option({}, WORLD_HELP)`,
        validates it with `check_world`, and applies it in `move` and `play`.
        """
        return {}

    def checks(self) -> Sequence[Mapping[str, float]]:
        """Return worlds in which a gait that is good in practice still works; none by default.

        Each is one or more values of `conditions` by name. A run ends with the share of its
        distance that the champion keeps in the worst of them.
        """
        return ()

    def design_space(self) -> Mapping[str, Dimension]:
        """Return the dimensions that factors change, by name; {} by default.

        A body with dimensions has the options `dimensions: dict[str, float]`, `evolve: tuple[str,
        ...]` and `ranges: dict[str, tuple[float, float]]`, and validates them with
        `check_dimensions`. The dimensions in `evolve` are genes: `factor_bounds` returns their
        bounds.
        """
        return {}

    def embody(self, genome: Genomes) -> tuple[Self, Genomes]:
        """Return the body of an individual, with its own dimensions, and the rest of its genes.

        The returned body has no genes of dimensions, and moves exactly like the individual. In the
        default, the genes of the dimensions in `evolve` are the last ones, in this order; a body
        without such genes returns itself and the genome.

        Args:
            genome: genome of the individual, (genes,), or these last genes alone.
        """
        options, space = dict(self), self.design_space()
        evolve = options.get("evolve", ())
        names = [name for name in evolve if name in space]
        if not names:
            return self, genome
        genes = len(genome) - len(names)
        own = {
            "dimensions": options["dimensions"]
            | dict(zip(names, genome[genes:].tolist(), strict=True)),
            "evolve": tuple(name for name in evolve if name not in space),
            "ranges": {},
        }
        return self.model_copy(update=own), genome[:genes]

    def design(self) -> str:
        """Return how this body differs from that of its options' defaults, one line; '' if not.

        The default returns the changed dimensions, such as 'femur × 1.12 = 0.0896 m'.
        """
        factors = getattr(self, "dimensions", {})
        space = self.design_space() if factors else {}
        return ", ".join(
            f"{name} × {factor:.3g} = {factor * space[name].nominal:.3g} {space[name].unit}"
            for name, factor in factors.items()
        )

    def describe(self) -> Facts:
        """Return facts about the body with its options, such as its mass and its legs."""
        return {}

    def warnings(self) -> tuple[str, ...]:
        """Return likely mistakes in the options of this body, each with a remedy; () by default.

        `gaitsim robots check`, the start of a new run, `gaitsim show` and the terminal UI show
        them; `gs.evolve` issues them as Python warnings.
        """
        return ()

    def questions(self) -> tuple[Question, ...]:
        """Return what was guessed about the body's file, the costliest mistakes first.

        The default returns (). A question disappears once its option is set. `gaitsim robots check`
        and the terminal UI show them.
        """
        return ()

    def gait_warnings(self, genome: Genomes) -> tuple[str, ...]:
        """Return sentences about likely mistakes in one gait with the options of this body.

        The default returns (). The end of a run, `gaitsim show`, `gaitsim analyse` and the terminal
        UI show them.

        Args:
            genome: genome of one individual, (genes,), without genes of its body; see `embody`.
        """
        return ()

    @classmethod
    def library(cls) -> Facts:
        """Return facts about option values that the package bundles, such as its robots."""
        return {}

    def imported(self) -> BodyFile | None:
        """Return the file from which this process read the body; None by default.

        Optional, for bodies that register a format as an entry point of the group
        `gaitsim.files`. `gaitsim robots check` prints its repairs.
        """
        return None

    def joint_names(self) -> tuple[str, ...]:
        """Return the names of the joints of `joint_angles`; () for a body without this channel."""
        return ()

    def sliding_joints(self) -> tuple[str, ...]:
        """Return the joints whose values in `joint_angles` are metres of a slide; () by default."""
        return ()

    def passive_places(self) -> Array:
        """Return the places of joints without motors in the standing pose, (joints, 3) m."""
        return np.zeros((0, 3))

    def standing_pose(self) -> Array:
        """Return the joint angles in which the body stands at rest, (joints,) rad.

        Files for robots start and end in this pose. The default is zero for every joint; override
        it if the body stands in a different pose.
        """
        return np.zeros(len(self.joint_names()))

    def leg_joints(self) -> Mapping[str, tuple[str, ...]]:
        """Return the names of each leg's joints by name of the leg; {} for a body without legs.

        A body with legs has a measure of the duty factor of each leg, as
        `gaitsim.legged.stepping_measures` computes it; an atlas uses these measures to distinguish
        gaits. If the body has an option `damage`, which `gaitsim.legged.parse_damage` parses, its
        gaits can be adapted to damage.
        """
        return {}

    def reflex_names(self) -> tuple[str, ...]:
        """Return the reflexes in the options, whose packages a run needs; () by default."""
        return ()

    def controller(self, genome: Genomes) -> Controller | None:
        """Return a gait as a rhythm with its reflexes, for export; None for other bodies.

        Args:
            genome: genome of one individual, (genes,), without genes of its body; see `embody`.
        """
        return None

    def fit_gait(
        self, joint_angles: Array, frequency: float, frame_rate: float, *, steered: bool = True
    ) -> FittedGait | None:
        """Return the gait of this body that is closest to periodic joint angles; None by default.

        Optional, for bodies whose gaits follow commands. If such a body is the twin of a kinematic
        body, gaits of the latter can be steered, and exported with reflexes. A search can begin at
        the fitted gait.

        Args:
            joint_angles: angles over whole strides, (frames, joints) rad.
            frequency: strides per second, Hz.
            frame_rate: frames per second, Hz.
            steered: whether the gait must follow commands, if need be with a reflex.
        """
        return None

    def blind(self, genomes: Genomes) -> "tuple[Organism, Genomes] | None":
        """Return the same body without its reflexes, and the genomes without their genes.

        The default returns None: the body has no reflexes.

        Args:
            genomes: genomes of a population, (population, genes).
        """
        return None

    def commands(self) -> tuple[Command, ...]:
        """Return the commands that a person can give, each with its own key.

        The first command ends the others, such as hovering or standing, and is in force at the
        start. The default returns (): the body cannot be steered.
        """
        return ()

    def controller_names(self) -> tuple[str, ...]:
        """Return the names of the controllers that obey the commands.

        By default, each command has its own controller of the same name. A body whose only
        controller obeys all commands returns one name, such as ('gait',); any individual of the
        body can then be steered.
        """
        return tuple(command.name for command in self.commands())

    def controllers(self) -> Mapping[str, Genomes]:
        """Return the controllers of the package by name: genomes of shape (genes,).

        Controllers fit only bodies with the options with which they were trained. Return {} if the
        options of this body give it a different genome space, such as that of a larger network.
        """
        return {}

    def steer(self, controllers: Mapping[str, Genomes]) -> Steered:
        """Return the body in its initial state, ready to be steered.

        Args:
            controllers: a genome (genes,) for each of `controller_names()`, by name.

        Raises:
            GaitsimError: the body cannot be steered, or a controller is missing or does not fit.
        """
        raise GaitsimError(
            f"the body {type(self).__name__} cannot be steered",
            allowed="a body with the methods commands(), controllers() and steer()",
        )
