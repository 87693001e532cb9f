"""How an imitator does beside its teacher, on the same body under the same fitness."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gaitsim.contracts import Motion
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.scoring import evaluate_motion
from gaitsim.experiment import Experiment
from gaitsim.imitation.imitator import Angles
from gaitsim.registry import plugin_errors

TOLERANCE = 1e-6  # rad: less is rounding, no limit


@dataclass(frozen=True, eq=False)
class Performance:
    """How one gait does.

    Attributes:
        score: under the experiment's fitness.
        terms: of the score.
        measures: value and unit by name, as the body measures itself.
    """

    score: float
    terms: dict[str, float]
    measures: dict[str, tuple[float, str]]

    @cached_property
    def plain(self) -> dict[str, object]:
        """For JSON."""
        return {
            "score": self.score,
            "terms": self.terms,
            "measures": {name: value for name, (value, _) in self.measures.items()},
        }


def performance(experiment: Experiment, motion: Motion) -> Performance:
    """How the one individual of a motion does.

    Raises:
        PluginError: the body or the fitness fails or breaks its contract; names its package.
    """
    judged = evaluate_motion(experiment, motion, 1)
    with plugin_errors(experiment.entries["organism"], "measuring a gait"):
        measures = {
            str(name): (float(measure.values[0]), measure.unit)
            for name, measure in experiment.organism.measures(motion).items()
        }
    terms = {name: float(values[0]) for name, values in judged.terms.items()}
    return Performance(float(judged.scores[0]), terms, measures)


def played(experiment: Experiment, asked: Angles) -> tuple[Motion, Angles, int]:
    """Play a gait on the body, which holds it to its limits.

    Args:
        experiment: whose body plays.
        asked: (frames, joints), radians.

    Returns:
        The motion; the angles as the body played them, (frames, joints); and how many of
        them are not what was asked.

    Raises:
        GaitsimError: the body cannot play, or the gait is not for it.
    """
    motion = play(experiment, asked[None])
    angles = np.asarray(motion["joint_angles"][0], dtype=np.float64)
    return motion, angles, int(np.count_nonzero(np.abs(angles - asked) > TOLERANCE))
