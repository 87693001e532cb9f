"""Read a run for the laboratory and simulate its individuals on a damaged body."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gaitsim.adaptation.prior import DEFAULT_MEASURE
from gaitsim.errors import GaitsimError
from gaitsim.gait.changed import (
    can_be_damaged,
    damage_body,
    has_twin,
    play_on_twin,
    twin_of,
    with_damage,
)
from gaitsim.gait.report import frames_before_fall
from gaitsim.individual import Individual, Which
from gaitsim.render.terminal.plan import Plan, plan_of
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.tui.damage_choice import Choice, Legs, damage_texts


@dataclass(frozen=True, eq=False)
class Walk:
    """A walk of an individual on a body.

    Attributes:
        individual: individual with a computed skeleton.
        forward: distance walked, m.
        fell: time of the fall, s; None if it did not fall.
    """

    individual: Individual
    forward: float
    fell: float | None


@dataclass(frozen=True, eq=False)
class Subject:
    """A run whose body can be damaged.

    Attributes:
        run: snapshot of the run.
        champion: individual to watch, on the body of the run.
        legs: joints by leg.
        plan: plan of the body.
    """

    run: RunSnapshot
    champion: Individual
    legs: Legs
    plan: Plan

    def check(self, damage: Choice, *, physics: bool) -> None:
        """Check whether the body, or its twin, can have this damage."""
        (twin_of if physics else damage_body)(self.champion.experiment, damage_texts(damage))

    def damaged_legs(self, damage: Choice) -> list[str]:
        """Return the legs that are lost or have a damaged joint."""
        parts = {one.part for one in damage}
        return [leg for leg, joints in self.legs.items() if parts & {leg, *joints}]

    @property
    def unadaptable(self) -> str:
        """The reason why its gait cannot be adapted; '' if it can."""
        if self.run.experiment.search.keeps == "archive":
            return ""
        return "The run is not an atlas: its search keeps no archive. 'gaitsim atlas' evolves one."

    @property
    def has_twin(self) -> bool:
        """Whether the body has a twin in rigid-body physics."""
        return has_twin(self.champion)


def read_subject(path: Path, which: Which = None) -> Subject:
    """Read a run."""
    run = RunSnapshot(path)
    champion = run.individual(which)
    legs = champion.experiment.organism.leg_joints()
    if not (legs and can_be_damaged(champion.experiment)):
        raise GaitsimError(
            f"the body {champion.experiment.entries['organism'].name!r} cannot be damaged",
            where=str(path),
            allowed="a body with legs and the option 'damage', such as the spider",
        )
    return Subject(run, champion, legs, _plan(champion, legs))


def simulate_walk(individual: Individual, damage: Choice, physics: bool) -> Walk:
    """Simulate an individual on a damaged body, or on its twin in rigid-body physics."""
    found = (play_on_twin if physics else with_damage)(individual, damage_texts(damage))
    _ = found.skeleton  # computed here because it is slow
    forward = found.measurements.get(DEFAULT_MEASURE)
    path = found.skeleton.path
    frames = frames_before_fall(found)
    return Walk(
        found,
        float(path[-1, 0] - path[0, 0]) if forward is None else forward.value,
        None if frames == len(path) else frames / found.skeleton.frame_rate,
    )


def _plan(champion: Individual, legs: Legs) -> Plan:
    """Return the plan of the body with all joints at 0.

    A body that cannot play joint angles is shown at the start of its walk.
    """
    organism = champion.experiment.organism
    if organism.can_play:
        still = np.zeros((1, 2, len(organism.joint_names())))
        return plan_of(organism.skeleton(organism.play(still), 0), legs)
    return plan_of(champion.skeleton, legs)
