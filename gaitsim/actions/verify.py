"""`gaitsim verify`."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from gaitsim.actions.action import JSON, RUN_OR_CODE, WORKERS, Action, argument
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import echo, print_json, print_table, status
from gaitsim.console.progress_bar import Progress
from gaitsim.contracts.plugin import option
from gaitsim.errors import GaitsimError
from gaitsim.sharing.code import PREFIX

if TYPE_CHECKING:
    from gaitsim.sharing.challenge import Challenge, CodeVerdict
    from gaitsim.storage.verification import Verdict


DIFFERENT = 1  # exit code
SHOWN = 20  # maximum number of differences


class VerifyResults(Action):
    """Repeat a run, study, adaptation or challenge code, and compare every bit.

    Given a challenge code, or a text that contains one, the command plays the individual and
    compares its score with the score in the code. That the individual is the best of its
    generation is a statement of the code's author, which nothing can check.

    Given a run, the command compares its files with one another, and evolves the run again from its
    options and its seed. Of a run that took more than a minute, it only evaluates the best
    individual of each generation and the last population again; --all evolves all of it.

    Given the folder of a study, a comparison or a report of 'gaitsim adapt', or the file of an
    adaptation, the command does a random part of it again, or with --all everything. --atlas names
    the run that a report adapts.

    A table says for each file whether it is the same, differs or cannot be known. The exit code is
    0 if everything is identical, 1 if something differs or a file is damaged, and 2 if nothing can
    be verified, such as a missing run or an invalid code.

    [bold]Examples[/bold]

    gaitsim verify spider

    gaitsim verify spider --all --workers 2

    gaitsim verify studies/mine --all

    gaitsim verify runs/spider-atlas/adaptations/L2-lost.json

    gaitsim verify losses --atlas spider-atlas

    gaitsim verify gaitsim1-8gAAAGNl…

    gaitsim share spider | gaitsim verify -
    """

    run: str = argument(
        f"{RUN_OR_CODE}; or the folder of a study, a comparison or a report, or the file of an "
        "adaptation",
        "RUN|CODE|FILE",
    )
    all_: bool = option(False, "repeat everything; a run, up to the first difference", flag="--all")
    atlas: str | None = option(
        None,
        "run of the atlas of an adaptation",
        unset="the run whose folder contains it",
        placeholder="RUN",
    )
    workers: int | None = WORKERS
    json_lines: bool = JSON

    def do(self) -> None:
        """Verify the code or the files, and print the verdict."""
        from gaitsim.console.codes import read_challenge

        try:
            challenge = read_challenge(self.run)
        except GaitsimError as error:
            if self.json_lines:
                print_json({"identical": None, "error": error.to_dict()})
            raise
        if challenge is None:
            identical = self._verify_files()
        elif self.all_ or self.atlas is not None:
            raise GaitsimError(
                "a challenge code has no parts", where="--all, --atlas", remedy="omit these options"
            )
        else:
            identical = _verify_code(challenge, self.json_lines)
        if not identical:
            sys.exit(DIFFERENT)

    def _verify_files(self) -> bool:
        from gaitsim.storage.files.folder import find_run
        from gaitsim.verifying import find_verifier, verify_files

        path, unit = self.run, "steps"
        if find_verifier(path) is None:
            unit = "generations"
            if os.path.isfile(path):  # noqa: PTH113
                raise GaitsimError(
                    f"the file {path} does not hold a challenge code",
                    allowed=f"a code that begins with {PREFIX}, or the name or folder of a run",
                )
            path = str(find_run(path))
        with interruptible(), Progress(os.path.basename(path), unit) as progress:  # noqa: PTH119
            verdict = verify_files(
                path,
                self.atlas,
                everything=self.all_ or None,
                workers=self.workers,
                begin=progress.expect,
                advance=progress.advance,
            )
        (_print_json if self.json_lines else _print)(path, verdict)
        return verdict.identical


def _verify_code(challenge: Challenge, json: bool) -> bool:
    """Play the individual of a challenge code; print and return whether its score is as claimed."""
    from gaitsim.sharing.challenge import verify_challenge

    with interruptible(), status("Playing the individual of the challenge code …"):
        checked = verify_challenge(challenge)
    if json:
        print_json(
            {
                "experiment": challenge.experiment.name,
                "stated_generation": challenge.generation,
                "stated_member": challenge.member,
                "identical": checked.identical,
                "claimed": challenge.score,
                "score": checked.score,
                "terms": checked.terms,
                "failure": checked.failure or None,
                "versions": dict(challenge.versions),
                "version_differences": list(checked.version_differences),
                "results": challenge.experiment.portability.partition(":")[0],
                "portability": challenge.experiment.portability,
            }
        )
    else:
        _print_checked(checked)
    return checked.identical


def _print_checked(checked: CodeVerdict) -> None:
    challenge = checked.challenge
    name, unit = challenge.experiment.name, challenge.experiment.fitness.unit
    _warn_of_other_machine(challenge.experiment.portability, checked.version_differences)
    if checked.identical:
        echo(f"{name}: reproduced, the score is {challenge.score!r} {unit}".rstrip())
    else:
        echo(f"{name}: not reproduced")
        echo(f"  claimed: {challenge.score!r} {unit}".rstrip())
        echo(f"  here:    {checked.score!r} {unit}".rstrip())
        if math.isfinite(checked.score):
            echo(f"  differs by {abs(checked.score - challenge.score):.2g} {unit}".rstrip())
        if checked.failure:
            echo(f"  failed:  {checked.failure}")
    best = "" if challenge.member else "the best of "
    echo(f"not checked: that it is {best}{challenge.individual.label}, as the code's author states")
    portability = challenge.experiment.portability
    for text in _describe_versions(
        bool(challenge.versions), checked.version_differences, "code", portability
    ):
        echo(text)
    if not (checked.identical or checked.version_differences or not challenge.versions):
        echo("so the claimed score is not the score of this individual")


def _print_json(path: str, verdict: Verdict) -> None:
    print_json(
        {
            verdict.kind.replace(" ", "_"): path,
            "identical": verdict.identical,
            "complete": verdict.complete,
            "total": verdict.total,
            "again": verdict.again,
            "differences": [one._asdict() for one in verdict.differences],
            "files": [one._asdict() for one in verdict.files],
            "notes": verdict.notes,
            "provenance": [{"first": origin.first, **origin.parts} for origin in verdict.origins],
            "version_differences": list(verdict.version_differences),
            "results": verdict.portability.partition(":")[0],
            "portability": verdict.portability,
            "score_difference": verdict.score_difference,
        }
    )


def _print(path: str, verdict: Verdict) -> None:
    _warn_of_other_machine(verdict.portability, verdict.version_differences)
    some = "" if verdict.complete else " in all that was compared"
    echo(f"{path}: identical{some}" if verdict.identical else f"{path}: different")
    for one in verdict.differences[:SHOWN]:
        echo(f"  {one}")
    if len(verdict.differences) > SHOWN:
        echo(f"  and {len(verdict.differences) - SHOWN} more")
    if verdict.score_difference:
        echo(f"  largest difference of a best score: {verdict.score_difference:.2g}")
    ranges = f": {_ranges(verdict.again)}" if verdict.again else ""
    echo(f"{len(verdict.again):,} of {verdict.total:,} {verdict.parts} again{ranges}")
    for note in verdict.notes:
        echo(note)
    print_table(("file", "result", ""), verdict.files)
    if verdict.portability:
        for text in _describe_versions(
            bool(verdict.origins), verdict.version_differences, "run", verdict.portability
        ):
            echo(text)


def _warn_of_other_machine(portability: str, version_differences: Sequence[str]) -> None:
    """Say before the verdict that results may differ here, unless they are portable."""
    from gaitsim.experiment import PORTABLE
    from gaitsim.storage.provenance import MACHINE

    name, _, meaning = portability.partition(": ")
    machine = tuple(f"{part}: " for part in MACHINE)
    if name != PORTABLE and any(text.startswith(machine) for text in version_differences):
        echo(f"computed on another kind of machine; the results are {name} ({meaning})")


def _describe_versions(
    recorded: bool, version_differences: Sequence[str], noun: str, portability: str
) -> list[str]:
    """Describe the class of the results, and whether this machine is like the one of the record."""
    from gaitsim.experiment import PORTABLE

    if not recorded:
        return [portability, f"the {noun} does not record the software versions"]
    if version_differences:
        return [
            portability,
            "computed with different software versions or on a different machine:",
            *(f"  {text}" for text in version_differences),
        ]
    same = "versions" if portability.startswith(PORTABLE) else "versions and processor"
    return [portability, f"same {same} as on this machine"]


def _ranges(numbers: tuple[int, ...]) -> str:
    """Join ordered numbers, with consecutive ones as '3 to 9'."""
    spans: list[list[int]] = []
    for number in numbers:
        if spans and number == spans[-1][1] + 1:
            spans[-1][1] = number
        else:
            spans.append([number, number])
    return ", ".join(_span(first, last) for first, last in spans)


def _span(first: int, last: int) -> str:
    return str(first) if first == last else f"{first} to {last}"
