"""Whether the score that a challenge code claims is true: its individual is played again."""

import struct
from dataclasses import dataclass

from gaitsim.evaluation import evaluate
from gaitsim.runs.files.provenance import Provenance, current_versions, differences
from gaitsim.sharing.challenge import Challenge


@dataclass(frozen=True, eq=False)
class Checked:
    """The result of verifying a challenge code.

    Attributes:
        challenge: what the code holds.
        score: the score that its individual has here; −inf if it fails.
        terms: the terms of that score by name.
        failure: why it fails here, or ''.
        elsewhere: where what made the code differs from what is here, a text each.
    """

    challenge: Challenge
    score: float
    terms: dict[str, float]
    failure: str
    elsewhere: tuple[str, ...]

    @property
    def true(self) -> bool:
        """Whether the score is the one that is claimed, to the last bit."""
        return struct.pack("d", self.score) == struct.pack("d", self.challenge.score)


def verify_challenge(challenge: Challenge) -> Checked:
    """Play the individual of a challenge in the worlds of its generation, and compare its score.

    Raises:
        ExperimentError: its experiment has problems, such as a plugin that is not installed.
        GaitsimError: its genome does not fit the body.
        PluginError: a plugin fails.
    """
    individual = challenge.individual
    experiment = individual.experiment
    found = evaluate(experiment, challenge.genome[None], challenge.generation)
    return Checked(
        challenge,
        float(found.scores[0]),
        found.terms_of(0),
        found.reasons.get(0, ""),
        _elsewhere(challenge, current_versions(experiment)),
    )


def _elsewhere(challenge: Challenge, now: dict[str, str]) -> tuple[str, ...]:
    """Return where what made a code differs from what is here."""
    made = dict(challenge.versions)
    if ("numba" in made) != ("numba" in now):  # which names the processor, where it is loaded
        for parts in (made, now):
            if "processor" in parts:
                parts["processor"] = parts["processor"].rpartition(", ")[2]
    return tuple(differences([Provenance(challenge.generation, made)], now))


def verify_code(code: str) -> Checked:
    """Play the individual of a challenge code, and compare its score with the one it claims.

    Raises:
        ExperimentError: its experiment has problems, such as a plugin that is not installed.
        GaitsimError: the text is not a code, is of another format, damaged or invalid.
        PluginError: a plugin fails.
    """
    return verify_challenge(Challenge.read(code))
