"""The motion of a population of walkers, recorded from their rollouts."""

from collections.abc import Iterable

import numpy as np

from gaitsim.contracts import Array, Motion
from gaitsim_walker import body
from gaitsim_walker.body import FRAME_RATE, Floats
from gaitsim_walker.rollout import Rollout, roll_out
from gaitsim_walker.surroundings import Surroundings


def walk(surroundings: Surroundings, commands: Iterable[Floats]) -> Motion:
    """Simulate walkers one after the other, and return their motion.

    Args:
        surroundings: body, ground and servos; each walker is simulated separately.
        commands: servo commands of each walker, (frames, joints) rad.
    """
    commanded, rolled = [], []
    for wanted in commands:
        rollout = roll_out(surroundings, wanted)
        held = wanted.copy()
        held[rollout.lasted :] = wanted[min(rollout.lasted, len(wanted) - 1)]
        commanded.append(held)
        rolled.append(rollout)
    measured = [_measured(surroundings, rollout) for rollout in rolled]

    def all_of(name: str) -> Array:
        return np.stack([getattr(rollout, name) for rollout in rolled])

    position, velocity = (
        body.to_3d(all_of("position")),
        body.to_3d(all_of("velocity")),
    )
    load, pitch = all_of("load"), all_of("pitch")
    lasted = np.array([max(rollout.lasted, 1) - 1 for rollout in rolled]) / FRAME_RATE
    return Motion(
        FRAME_RATE,
        {
            "joint_angles": np.stack(commanded),
            "joint_positions": all_of("joints"),
            "torque": all_of("torque"),
            "stall_torque": np.full(
                (len(rolled), len(surroundings.plan.joints)), surroundings.torque_limit, np.float64
            ),
            "torso": position,
            "torso_velocity": velocity,
            "pitch": pitch,
            "orientation": np.stack([np.zeros_like(pitch), -pitch, np.zeros_like(pitch)], axis=-1),
            "height": np.stack([height for height, _, _ in measured]),
            "foot_positions": np.stack([feet for _, feet, _ in measured]),
            "stance": load[..., 1] > 0,
            "load": load,
            "slip": np.stack([slip for _, _, slip in measured]),
            "energy": all_of("work"),
            "lasted": lasted,
            "weight": np.full(len(rolled), surroundings.weight),
            "length": np.full(len(rolled), body.TORSO_LENGTH),
        },
        failures={i: rollout.failure for i, rollout in enumerate(rolled) if rollout.failure},
    )


def _measured(surroundings: Surroundings, rollout: Rollout) -> tuple[Floats, Floats, Floats]:
    """Return height (frames,), feet (frames, legs, 3) and slip (frames,) of one walker, m.

    They are computed for one walker at a time, so that array shapes, and hence rounding, do not
    depend on the population.
    """
    plan = surroundings.plan
    feet = body.leg_points(plan, rollout.position, rollout.pitch, rollout.joints)[:, :, 2]
    turned = body.limb_angles(plan, rollout.joints)[:, 1::2] + rollout.pitch[:, None]
    # A round foot that rolls without sliding moves back as its shank turns forward.
    slid = np.abs(np.diff(feet[..., 0], axis=0) + body.FOOT_RADIUS * np.diff(turned, axis=0))
    stance = rollout.load[..., 1] > 0
    standing = stance[1:] & stance[:-1]
    slip = np.zeros(len(feet))
    slip[1:] = (slid * standing).sum(axis=1) / np.maximum(standing.sum(axis=1), 1)
    below = [surroundings.ground.height(x) for x in rollout.position[:, 0].tolist()]
    return rollout.position[:, 1] - np.array(below), body.to_3d(feet), slip
