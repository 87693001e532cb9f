"""Challenge codes as the command line takes them: the code itself, a file, standard input."""

import os
import sys
from dataclasses import replace
from pathlib import Path

from gaitsim.cli.console import notice, status
from gaitsim.errors import GaitsimError
from gaitsim.individual import Asked, Individual
from gaitsim.opening import read_regular
from gaitsim.runs.files.checkpoint import Champion
from gaitsim.runs.files.folder import RUNS, find_run, holds_run
from gaitsim.runs.files.provenance import current_versions
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.sharing.challenge import Challenge
from gaitsim.sharing.checking import verify_challenge
from gaitsim.sharing.code import LONGEST, looks_like_code

STANDARD_INPUT = "-"


def given_challenge(reference: str) -> Challenge | None:
    """Return the challenge of a code, of a file with one, or of '-'; None for something else.

    Raises:
        GaitsimError: the code is damaged, invalid or of another format, or cannot be read.
    """
    if reference == STANDARD_INPUT:
        return Challenge.read(sys.stdin.buffer.read(2 * LONGEST + 1).decode("utf-8", "replace"))
    # os.path, unlike pathlib, answers for names that no file can have, too.
    if os.path.isfile(reference):  # noqa: PTH113
        text = _text(Path(reference))
        return Challenge.read(text) if looks_like_code(text) else None
    if any(holds_run(path) for path in (Path(reference), RUNS / reference)):
        return None
    return Challenge.read(reference) if looks_like_code(reference) else None


def given_individual(reference: str, asked: Asked) -> Individual:
    """Return the individual of a code, or one of a run.

    Raises:
        GaitsimError: a code is given, and a generation or member is asked for.
        RunError: there is no such run or individual.
    """
    challenge = given_challenge(reference)
    if challenge is None:
        return RunSnapshot(find_run(reference)).individual(asked)
    if asked is not None:
        raise GaitsimError(
            "a challenge code holds one individual",
            where="--generation, --member",
            remedy="leave them out",
        )
    return challenge.individual


def _text(path: Path) -> str:
    try:
        return read_regular(path, 2 * LONGEST, follow=True).decode("utf-8-sig", "replace")
    except OSError as error:
        raise GaitsimError(f"cannot read {path}: {error.strerror}") from None


def start_of(challenge: Challenge) -> Champion:
    """Return the individual that a run starts from, with the score that it really has here.

    Raises:
        GaitsimError: its experiment has problems, or it fails here.
    """
    with status("Verifying the challenge code …"):
        checked = verify_challenge(challenge)
    if checked.failure:
        raise GaitsimError(
            f"the individual of the challenge code fails here: {checked.failure}",
            where="--from",
            remedy=f"use the versions that made it: {challenge.made_with}",
        )
    if not checked.true:
        notice(
            f"The challenge code claims the score {challenge.score!r}; here it is "
            f"{checked.score!r}, which the run records."
        )
        versions = current_versions(challenge.experiment)
        challenge = replace(challenge, score=checked.score, versions=versions)
    return challenge.champion
