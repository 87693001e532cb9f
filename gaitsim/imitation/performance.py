"""How a gait performs: its score, its terms and its measures."""

from dataclasses import dataclass

import numpy as np

from gaitsim.contracts import Motion
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.scoring import evaluate_motion
from gaitsim.experiment import Experiment
from gaitsim.imitation.imitator import Angles
from gaitsim.registry import plugin_errors

TOLERANCE = 1e-6  # rad: smaller differences are rounding, not limits


@dataclass(frozen=True, eq=False)
class Performance:
    """The score and the measures of one gait.

    Attributes:
        score: under the experiment's fitness.
        terms: of the score.
        measures: value and unit by name, as the body measures itself.
    """

    score: float
    terms: dict[str, float]
    measures: dict[str, tuple[float, str]]

    def to_dict(self) -> dict[str, object]:
        """Return the numbers for JSON, without units."""
        return {
            "score": self.score,
            "terms": self.terms,
            "measures": {name: value for name, (value, _) in self.measures.items()},
        }


def performance(experiment: Experiment, motion: Motion) -> Performance:
    """Evaluate and measure the one individual of a motion.

    Raises:
        PluginError: the body or the fitness fails or breaks its contract; names its package.
    """
    evaluation = evaluate_motion(experiment, motion, 1)
    with plugin_errors(experiment.entries["organism"], "measuring a gait"):
        measures = {
            str(name): (float(measure.values[0]), measure.unit)
            for name, measure in experiment.organism.measures(motion).items()
        }
    terms = {name: float(values[0]) for name, values in evaluation.terms.items()}
    return Performance(float(evaluation.scores[0]), terms, measures)


def played(experiment: Experiment, commanded: Angles) -> tuple[Motion, Angles, int]:
    """Play a gait on the body, which limits its angles and speeds.

    Args:
        experiment: whose body plays.
        commanded: (frames, joints), radians.

    Returns:
        The motion, the angles that the body played, (frames, joints), and how many of them
        differ from the commanded ones.

    Raises:
        GaitsimError: the body cannot play, or the gait is not for it.
    """
    motion = play(experiment, commanded[None])
    angles = np.asarray(motion["joint_angles"][0], dtype=np.float64)
    return motion, angles, int(np.count_nonzero(np.abs(angles - commanded) > TOLERANCE))
