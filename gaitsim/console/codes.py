"""Challenge codes on the command line: as an argument, in a file, or on standard input."""

import sys
from dataclasses import replace

from gaitsim.console.printing import notice, status
from gaitsim.errors import GaitsimError
from gaitsim.individual import Choice, Individual
from gaitsim.sharing.challenge import Challenge, find_challenge, verify_challenge
from gaitsim.sharing.code import LONGEST
from gaitsim.storage.files.checkpoint import Champion
from gaitsim.storage.provenance import current_versions
from gaitsim.storage.snapshot import RunSnapshot

STANDARD_INPUT = "-"


def read_challenge(reference: str) -> Challenge | None:
    """Return the challenge in a code, in a file that holds a code, or on standard input for '-'.

    Returns None if the reference is none of these.
    """
    if reference == STANDARD_INPUT:
        return Challenge.read(sys.stdin.buffer.read(2 * LONGEST + 1).decode("utf-8", "replace"))
    return find_challenge(reference)


def read_individual(reference: str, choice: Choice) -> Individual:
    """Return the individual of a challenge code, or the requested one of a run."""
    challenge = read_challenge(reference)
    if challenge is None:
        return RunSnapshot.find(reference).individual(choice)
    if choice is not None:
        raise GaitsimError(
            "a challenge code holds only one individual",
            where="--generation, --member",
            remedy="omit both options",
        )
    return challenge.individual


def challenge_as_start(challenge: Challenge) -> Champion:
    """Return a challenge's individual as the start of a run, with its score on this machine."""
    with status("Verifying the challenge code …"):
        checked = verify_challenge(challenge)
    if checked.failure:
        raise GaitsimError(
            f"the individual of the challenge code fails on this machine: {checked.failure}",
            where="--from",
            remedy=f"install the versions that computed it: {challenge.made_with}",
        )
    if not checked.identical:
        notice(
            f"The challenge code claims the score {challenge.score!r}; on this machine it is "
            f"{checked.score!r}, which the run records."
        )
        versions = current_versions(challenge.experiment)
        challenge = replace(challenge, score=checked.score, versions=versions)
    return challenge.champion
