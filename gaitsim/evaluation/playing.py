"""Play given joint angles, such as those of a network or a file, on an experiment's body."""

import numpy as np
from numpy.typing import ArrayLike

from gaitsim.contracts import Motion
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.scoring import check_motion
from gaitsim.experiment import Experiment
from gaitsim.registry import contract_error, plugin_errors


def require_play(experiment: Experiment) -> None:
    """Check that the body can play joint angles."""
    entry, organism = experiment.entries["organism"], experiment.organism
    if "joint_angles" not in organism.channels:
        problem, allowed = "has no joint angles", "a body with the channel 'joint_angles'"
    elif not organism.can_play:
        problem, allowed = "cannot play given joint angles", "a body with the method play()"
    else:
        return
    raise GaitsimError(f"{entry} {problem}", where=experiment.name, allowed=allowed)


def play(experiment: Experiment, joint_angles: ArrayLike) -> Motion:
    """Return the motion of the experiment's body with given joint angles.

    Args:
        experiment: experiment with the body.
        joint_angles: angles to play, (population, frames, joints), radians. The body clips them to
            its limits; the motion's channel `joint_angles` holds the angles that it played.
    """
    require_play(experiment)
    entry, organism = experiment.entries["organism"], experiment.organism
    angles = np.array(joint_angles, dtype=np.float64)  # a copy, in case the body changes it
    with plugin_errors(entry, "naming its joints"):
        joints = len(organism.joint_names())
    if angles.ndim != 3 or angles.shape[1] < 2 or angles.shape[2] != joints:
        raise GaitsimError(
            f"joint angles of shape {angles.shape} do not fit {entry}",
            allowed=f"(population, frames, joints), with {joints} joints and at least 2 frames",
            remedy="use a gait of the same body",
        )
    if not np.isfinite(angles).all():
        raise GaitsimError("some joint angles are not finite", allowed="finite numbers, in radians")
    with plugin_errors(entry, "playing joint angles"):
        motion = check_motion(entry, organism.play(angles))
        shape = np.shape(motion["joint_angles"])
    if shape != angles.shape:
        raise contract_error(
            entry,
            f"returned joint_angles of shape {shape} from play()",
            f"the shape of its argument, {angles.shape}",
        )
    return motion
