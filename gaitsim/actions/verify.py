"""`gaitsim verify`."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gaitsim.actions.action import (
    JSON,
    RUN_OR_CODE,
    WORKERS,
    Action,
    Generations,
    argument,
    not_combinable,
)
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import echo, print_json, print_table, status
from gaitsim.console.progress_bar import Progress
from gaitsim.contracts.plugin import option
from gaitsim.errors import GaitsimError
from gaitsim.sharing.code import PREFIX
from gaitsim.storage.files.folder import EXPERIMENT
from gaitsim.toml import literal

if TYPE_CHECKING:
    from gaitsim.sharing.challenge import Challenge, Checked
    from gaitsim.storage.accounts import FilesVerdict
    from gaitsim.storage.verification import Verdict


DIFFERENT = 1  # exit code
MOST_DIFFERENCES = 20  # of a study
SHOWN = 5  # generations that differ, and parts of one


class VerifyResults(Action):
    """Repeat a run, study, adaptation or challenge code, and compare every bit.

    Given a challenge code, or a text that contains one, the command plays the individual and
    compares its score with the score in the code. That the individual is the best of its
    generation is a statement of the code's author, which nothing can check.

    Given a run, the command compares all its files with one another, and experiment.toml with the
    options of the last generation. Then it evolves the run again from the options and the seed. Of
    a run that took more than a minute, it evolves a few generations again, and the best individual
    of every other; --all evolves all of it. A table says what was compared, and what cannot be
    known.

    Given the folder of a study, a comparison or a report of 'gaitsim adapt', or the file of an
    adaptation, the command does some of it again, or with --all everything, and compares scores,
    trials, tables and reports. --atlas names the run that a report adapts.

    The exit code is 0 if everything is identical, 1 if something differs or a file is damaged, and
    2 if nothing can be verified, such as a missing run or an invalid code.

    [bold]Examples[/bold]

    gaitsim verify spider

    gaitsim verify spider --all --workers 2

    gaitsim verify spider --generations 1,50,100 --json

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
    generations: Generations | None = option(
        None,
        "generations to reproduce; in full if their parents are kept",
        unset="the whole run if it took at most a minute; otherwise a part",
        placeholder="N,N,…",
    )
    all_: bool = option(False, "reproduce the whole run, up to the first difference", flag="--all")
    atlas: str | None = option(
        None,
        "run of the atlas of an adaptation",
        unset="the run whose folder contains it",
        placeholder="RUN",
    )
    workers: int | None = WORKERS
    json_lines: bool = JSON

    def do(self) -> None:
        """Verify the code or the run, and print the verdict."""
        from gaitsim.console.codes import read_challenge
        from gaitsim.verifying import files_kind

        if self.all_ and self.generations is not None:
            raise not_combinable("--all", "--generations")
        try:
            challenge = read_challenge(self.run)
        except GaitsimError as error:
            if self.json_lines:
                print_json({"identical": None, "error": error.to_dict()})
            raise
        kind = files_kind(Path(self.run)) if challenge is None else ""
        if kind:
            self._verify_files(kind)
        elif self.atlas is not None:
            raise GaitsimError("only adaptations have an atlas", where="--atlas", remedy="omit it")
        elif challenge is None:
            self._verify_run()
        elif self.all_ or self.generations is not None:
            raise GaitsimError(
                "a challenge code has no generations",
                where="--all, --generations",
                remedy="omit these options",
            )
        else:
            _verify_code(challenge, self.json_lines)

    def _verify_files(self, kind: str) -> None:
        from gaitsim.verifying import verify_files

        if self.generations is not None:
            raise GaitsimError(
                f"{_a(kind)} has no generations", where="--generations", remedy="omit it"
            )
        path = Path(self.run)
        with interruptible(), Progress(path.name, "steps") as progress:
            verdict = verify_files(
                path,
                self.atlas,
                everything=self.all_,
                workers=self.workers,
                begin=progress.expect,
                advance=progress.advance,
            )
        if self.json_lines:
            print_json(
                {
                    kind.replace(" ", "_"): str(path),
                    "identical": verdict.identical,
                    "complete": verdict.complete,
                    "total": verdict.total,
                    "again": verdict.again,
                    "differences": verdict.differences,
                    "notes": verdict.notes,
                    "files": [account._asdict() for account in verdict.accounts],
                }
            )
        else:
            _print_files(path, verdict)
        if not verdict.identical:
            sys.exit(DIFFERENT)

    def _verify_run(self) -> None:
        from gaitsim.storage.snapshot import RunSnapshot
        from gaitsim.storage.verification import verify

        if os.path.isfile(self.run):  # noqa: PTH113
            raise GaitsimError(
                f"the file {self.run} does not hold a challenge code",
                allowed=f"a code that begins with {PREFIX}, or the name or folder of a run",
            )
        run = RunSnapshot.find(self.run)
        with interruptible(), Progress(run.path.name, "generations") as progress:
            verdict = verify(
                run,
                self.generations or None,
                everything=self.all_ or None,
                workers=self.workers,
                begin=progress.expect,
                advance=progress.advance,
            )
        show = _print_json if self.json_lines else _print
        show(str(run.path), verdict)
        if not verdict.identical:
            sys.exit(DIFFERENT)


def _a(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _print_files(path: Path, verdict: FilesVerdict) -> None:
    some = "" if verdict.complete else " in all that was compared"
    echo(f"{path}: identical{some}" if verdict.identical else f"{path}: different")
    for text in verdict.differences[:MOST_DIFFERENCES]:
        echo(f"  {text}")
    if len(verdict.differences) > MOST_DIFFERENCES:
        echo(f"  and {len(verdict.differences) - MOST_DIFFERENCES} more")
    ranges = f": {_ranges(verdict.again)}" if verdict.again else ""
    echo(f"{len(verdict.again)} of {verdict.total} {verdict.parts} again{ranges}")
    for note in verdict.notes:
        echo(note)
    print_table(("file", "compared", "cannot be known"), verdict.accounts)


def _verify_code(challenge: Challenge, json: bool) -> None:
    """Play the individual of a challenge code, and print whether its score is as claimed."""
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
    if not checked.identical:
        sys.exit(DIFFERENT)


def _print_checked(checked: Checked) -> None:
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
    from pydantic_core import to_jsonable_python

    print_json(
        {
            "run": path,
            "identical": verdict.identical,
            "complete": verdict.complete,
            "generations": verdict.last,
            "reproduced": verdict.reproduced,
            "best_only": verdict.best_only,
            "not_reproduced": verdict.not_reproduced,
            "differences": [
                {"generation": number, "what": list(what)}
                for number, what in verdict.differences.items()
            ],
            "warning": verdict.warning or None,
            "damaged": list(verdict.damaged),
            "experiment": [
                {
                    "option": change.key,
                    "file": to_jsonable_python(change.now, serialize_unknown=True),
                    "used": to_jsonable_python(change.then, serialize_unknown=True),
                }
                for change in verdict.edited
            ],
            "provenance": [{"first": origin.first, **origin.parts} for origin in verdict.origins],
            "version_differences": list(verdict.version_differences),
            "results": verdict.portability.partition(":")[0],
            "portability": verdict.portability,
            "score_difference": verdict.score_difference,
            "files": [account._asdict() for account in verdict.accounts],
        }
    )


def _print(path: str, verdict: Verdict) -> None:
    _warn_of_other_machine(verdict.portability, verdict.version_differences)
    if verdict.identical:
        echo(f"{path}: identical{'' if verdict.complete else ' in all that was compared'}")
    elif not verdict.differences:
        echo(f"{path}: different, although the compared generations are identical")
    else:
        first, count = next(iter(verdict.differences)), len(verdict.differences)
        more = f"; {count - 1} more generations differ" if count > 1 else ""
        echo(f"{path}: different, first in generation {first}{more}")
    if not verdict.identical:
        for text in (*_changed_options(verdict), *verdict.damaged):
            echo(f"  {text}")
        for number, what in list(verdict.differences.items())[:SHOWN]:
            for text in what[:SHOWN]:
                echo(f"  generation {number}: {text}")
            if len(what) > SHOWN:
                echo(f"  generation {number}: and {len(what) - SHOWN} more")
        if verdict.score_difference:
            echo(f"  largest difference of a best score: {verdict.score_difference:.2g}")
    for text in _scope(verdict):
        echo(text)
    print_table(("file", "compared", "cannot be known"), verdict.accounts)
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


def _changed_options(verdict: Verdict) -> list[str]:
    """Return a text on the options of `experiment.toml` that differ from the run's; [] if none."""

    def value(found: Any) -> str:
        return "not set" if found is None else literal(found)

    if not verdict.edited:
        return []
    options = "; ".join(
        f"{change.key} is {value(change.now)} in the file, {value(change.then)} in the run"
        for change in verdict.edited
    )
    return [
        f"{EXPERIMENT} differs from the options of the run ({options}): "
        f"resuming would apply the file's options, starting with generation {verdict.last + 1}"
    ]


def _scope(verdict: Verdict) -> list[str]:
    """Describe what was reproduced."""
    if verdict.complete:
        found = [f"all {verdict.last} generations evolved again"]
    else:
        found = [f"{len(verdict.reproduced)} of {verdict.last} generations evolved again"]
        if verdict.reproduced:
            found[0] += f": {_ranges(verdict.reproduced)}"
        if verdict.best_only:
            found.append(f"only the best individual evaluated again: {_ranges(verdict.best_only)}")
        if verdict.not_reproduced:
            spans = ", ".join(_span(*span) for span in verdict.not_reproduced)
            found.append(f"only the files compared: {spans}")
        if verdict.identical:
            found.append("a forger could have changed the others: --all evolves them again")
    return found


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
