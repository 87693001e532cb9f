"""Verify a challenge code: replay its individual and compare the score."""

import struct
from dataclasses import dataclass

from gaitsim.evaluation import evaluate
from gaitsim.runs.files.provenance import Provenance, current_versions, differences
from gaitsim.sharing.challenge import Challenge


@dataclass(frozen=True, eq=False)
class Checked:
    """The result of verifying a challenge code.

    Attributes:
        challenge: content of the code.
        score: score of the individual on this machine; −inf if it fails.
        terms: terms of that score by name.
        failure: reason why the individual fails on this machine, or ''.
        version_differences: one message for each difference between the versions in the code and
            the installed versions.
    """

    challenge: Challenge
    score: float
    terms: dict[str, float]
    failure: str
    version_differences: tuple[str, ...]

    @property
    def identical(self) -> bool:
        """Whether the score equals the claimed score, to the last bit."""
        return struct.pack("d", self.score) == struct.pack("d", self.challenge.score)


def verify_challenge(challenge: Challenge) -> Checked:
    """Replay a challenge's individual in the worlds of its generation and compare the scores.

    Raises:
        ExperimentError: the experiment has problems, such as a plugin that is not installed.
        GaitsimError: the genome does not fit the body.
        PluginError: a plugin fails.
    """
    individual = challenge.individual
    experiment = individual.experiment
    made = Provenance(challenge.generation, dict(challenge.versions))
    found = evaluate(experiment, challenge.genome[None], challenge.generation)
    return Checked(
        challenge,
        float(found.scores[0]),
        found.terms_of(0),
        found.reasons.get(0, ""),
        tuple(differences([made], current_versions(experiment))),
    )


def verify_code(code: str) -> Checked:
    """Replay the individual of a challenge code and compare its score with the claimed one.

    Raises:
        ExperimentError: the experiment has problems, such as a plugin that is not installed.
        GaitsimError: the text is not a code, has a different format, or is damaged or invalid.
        PluginError: a plugin fails.
    """
    return verify_challenge(Challenge.read(code))
