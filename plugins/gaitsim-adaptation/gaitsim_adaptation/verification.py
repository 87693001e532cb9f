"""Verify adaptations: trials follow from the atlas, the settings and the measured values."""

import os
import secrets
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

from gaitsim.plugin import GaitsimError, RunError, read_regular
from gaitsim.plugin.runs import (
    ADAPTATIONS,
    CHECKPOINT,
    FileDifference,
    RunSnapshot,
    Verdict,
    Verifier,
    command,
    cores,
    file_results,
    holds_run,
)
from gaitsim_adaptation.champion import find_reference
from gaitsim_adaptation.prior import (
    OnProgress,
    Prior,
    atlas_checksum,
    atlas_members,
    intact_differences,
    intact_file,
    read_prior,
)
from gaitsim_adaptation.record import check_gaits, read_record
from gaitsim_adaptation.report import (
    FILE,
    SUMMARY,
    TRIALS,
    AdaptationReport,
    complete_report,
    figure_names,
    leg_losses,
    read_report,
    summary,
    trials_table,
)
from gaitsim_adaptation.settings import AdaptationSettings
from gaitsim_adaptation.trials import (
    Proposal,
    Trial,
    fit,
    individual_of,
    measure_intact,
    right_proposal,
    simulated_robot,
    transfer_map,
)

SAMPLES = 10
"""Number of cases of a report that are repeated by default."""

LARGEST = 100_000_000  # bytes of a table or summary
OTHER_ATLAS = "it belongs to another atlas, or to an earlier generation of this one"


def verify_adaptation(
    file: Path,
    run: RunSnapshot,
    *,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: OnProgress = lambda done: None,
) -> Verdict:
    """Compute the proposals of an adaptation again, and measure its trials in simulation again.

    Args:
        file: file of the adaptation.
        run: run of the atlas.
        workers: number of workers that evaluate the atlas; None for a number that suits the body.
        begin: callback with the number of gaits and trials to evaluate.
        advance: callback with the number of them evaluated since the last call.
    """
    record, members = read_record(file), atlas_members(run)
    if record is None:
        raise RunError(f"there is no adaptation {file}")
    trials, physics = record.trials, record.place == "physics"
    simulated = record.place != "robot"
    cache = intact_file(run.path, record.measure)
    cached: list[str] = []
    found, again = [OTHER_ATLAS], False
    if record.atlas == atlas_checksum(members):
        check_gaits(file, record, run.experiment_at(run.generation), len(members.scores))
        known = record.damage if record.known else ()
        begin(
            len(members.scores) * (1 + bool(known)) + len(record.intact) + simulated * len(trials)
        )
        prior = read_prior(
            run, record.measure, known, cached=False, workers=workers, on_progress=advance
        )
        cached = intact_differences(run, prior, known)
        found, again = [], simulated
        if physics:
            robot = simulated_robot(prior.experiment, (), record.measure, physics=True)
            with ThreadPoolExecutor(workers or cores(), "gaitsim") as pool:
                intact = measure_intact(run, prior, robot, pool, advance, cached=False)
            found += _intact_differences(record.intact, intact)
            prior = transfer_map(prior, record.intact)
        for at, one in enumerate(trials):
            if simulated or not any(earlier.revised for earlier in trials[:at]):
                found += _wrong_proposal(prior, trials[:at], record.settings, one)
        if simulated:
            robot = simulated_robot(
                prior.experiment, record.damage, record.measure, physics=physics
            )
            for one in trials:
                measured = robot(individual_of(prior, one))
                if {*one.values} != {measured}:
                    found.append(_wrong_measurement(one.number, one.values, measured))
                advance(1)
    count = len(trials)
    differences = [FileDifference(file.name, text) for text in found]
    differences += [FileDifference(cache.name, text) for text in cached]
    files, unknown = {}, _atlas(run)
    if again:
        files[file.name] = "except for deleted last trials"
    else:
        until = "up to the first correction" if any(one.revised for one in trials) else "all"
        unknown[file.name] = f"the results of the robot; proposals computed again: {until}"
    if cache.exists():
        files[cache.name] = "all gaits of the atlas evaluated again"
    return Verdict(
        "adaptation",
        "trials measured",
        count,
        tuple(range(1, count + 1)) if again else (),
        again,
        tuple(differences),
        file_results(differences, files, unknown),
    )


def verify_report(
    folder: Path,
    run: RunSnapshot,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: OnProgress = lambda done: None,
) -> Verdict:
    """Repeat cases of a report, and compute its tables again.

    Args:
        folder: folder of the report.
        run: run of the atlas.
        everything: whether to repeat all cases, rather than `SAMPLES` random ones.
        workers: number of gaits tried at a time; None for the number of cores.
        begin: callback with the number of gaits and cases to evaluate.
        advance: callback with the number of them evaluated since the last call.
    """
    members = atlas_members(run)
    report = read_report(folder / FILE, len(members.scores))
    if report is None:
        raise RunError(f"there is no report {folder / FILE}")
    number, finished = len(report.cases), (folder / SUMMARY).exists()
    chosen: list[int] = []
    found = [FileDifference(FILE, OTHER_ATLAS)]
    if report.atlas == atlas_checksum(members):
        count = number if everything else min(SAMPLES, number)
        chosen = sorted(secrets.SystemRandom().sample(range(number), count))
        begin(len(members.scores) + len(report.intact) + count)
        prior = read_prior(run, report.measure, cached=False, workers=workers, on_progress=advance)
        wrong = _wrong_cases(run, prior, report, chosen, workers, advance)
        found = [FileDifference(FILE, text) for text in wrong]
        if finished and not found:
            found += _wrong_files(folder, prior, report)
    rest = number - len(chosen)
    about = f"{len(chosen)} of {number} cases repeated"
    if report.reference and report.reference.run:
        about += f"; how far the champion of {report.reference.run} walks cannot be known"
    files, unknown = ({}, {FILE: about}) if rest else ({FILE: about}, {})
    if finished:
        files |= dict.fromkeys([TRIALS, SUMMARY], f"computed again from {FILE}")
        unknown |= dict.fromkeys(figure_names(report), f"whether it shows {TRIALS}")
    return Verdict(
        "adaptation report",
        "cases measured",
        number,
        tuple(at + 1 for at in chosen),
        finished and not rest,
        tuple(found),
        file_results(found, files, unknown | _atlas(run)),
        () if finished else (f"the report is not finished: it has no {SUMMARY} to compare",),
    )


def _atlas(run: RunSnapshot) -> dict[str, str]:
    how = f"how the atlas evolved: {command('verify', run.path)}"
    return {f"{run.path.resolve().name}/{CHECKPOINT}": how}


def _wrong_cases(
    run: RunSnapshot,
    prior: Prior,
    report: AdaptationReport,
    chosen: Sequence[int],
    workers: int | None,
    advance: OnProgress,
) -> list[str]:
    """Return the differences of a report whose chosen cases are repeated."""
    damages = [case.damage for case in report.cases]
    every = leg_losses(prior.experiment, pairs=True)
    if len({*damages}) < len(damages) or not {*damages} <= {*every}:
        return ["a case is there twice, or is not the loss of one or two legs"]
    if not all(fit(prior.experiment, case.trials) for case in report.cases):
        return ["a changed gait does not fit the body"]
    steps = [0]

    def on_case(done: int, total: int) -> None:
        advance(done - steps[0])
        steps[0] = done

    again = complete_report(
        run,
        prior,
        replace(report, intact={}, cases=()),
        [damages[at] for at in chosen],
        cached=False,
        workers=workers,
        on_atlas=advance,
        on_case=on_case,
    )
    found = _intact_differences(report.intact, again.intact)
    if report.reference and not report.reference.run:
        physics = report.place == "physics"
        if report.reference != find_reference(run, None, report.measure, physics=physics):
            found.append("the champion from which the atlas began performs differently")
    if report.unit != prior.unit:
        found.append(f"the unit is {prior.unit!r}, not {report.unit!r}")
    repeated = {case.damage: case for case in again.cases}
    for case in report.cases:
        if repeated.get(case.damage, case) != case:
            found.append(f"the case {case.name} differs when repeated")
    return found


def _wrong_files(folder: Path, prior: Prior, report: AdaptationReport) -> list[FileDifference]:
    """Return the tables of a finished report that do not follow from it."""
    text, table = _read(folder / SUMMARY), _read(folder / TRIALS)
    name = text.partition("\n")[0].removeprefix("# ").removesuffix(": adaptation to damage")
    known = {case.damage: case for case in report.cases}
    found = []
    for pairs in (False, True):  # a report may have been repeated without its pairs
        damages = leg_losses(prior.experiment, pairs=pairs)
        if {*damages} <= {*known}:
            part = replace(report, cases=tuple(known[damage] for damage in damages))
            right = {SUMMARY: summary(part, name, figure_names(part)), TRIALS: trials_table(part)}
            there = {SUMMARY: text, TRIALS: table}
            if right == there:
                return []
            found = [file for file in right if right[file] != there[file]]
    return [
        FileDifference(file, f"does not follow from {FILE}") for file in found or [SUMMARY, TRIALS]
    ]


def _read(file: Path) -> str:
    try:
        return read_regular(file, LARGEST).decode(errors="replace")
    except OSError as error:
        raise RunError(f"cannot read {file}: {error.strerror}") from None


def _wrong_proposal(
    prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings, proposal: Proposal
) -> list[str]:
    """Return how a proposal differs from the one that follows from earlier trials."""
    right = right_proposal(prior, trials, settings, proposal)
    if all(value == getattr(proposal, name) for name, value in vars(right).items()):
        return []
    gene = " with other genes" * (proposal.genome != right.genome)
    return [
        f"trial {proposal.number}: member {proposal.member}, {proposal.expected!r} ± "
        f"{proposal.deviation!r}, was proposed, but trial {right.number} follows, member "
        f"{right.member}, {right.expected!r} ± {right.deviation!r}{gene}"
    ]


def _wrong_measurement(trial: int, values: Sequence[float], measured: float) -> str:
    recorded = " and ".join(map(repr, values))
    return f"trial {trial}: {recorded} was recorded, but {measured!r} is measured"


def _intact_differences(then: Mapping[int, float], now: Mapping[int, float]) -> list[str]:
    if then == now:
        return []
    return ["the performance of gaits on the intact body differs from that measured again"]


def _verify_adaptation(
    path: Path, *, atlas: str | None, everything: bool, **options: Any
) -> Verdict:
    return verify_adaptation(path, RunSnapshot.find(atlas or _atlas_around(path)), **options)


def _verify_report(path: Path, *, atlas: str | None, **options: Any) -> Verdict:
    return verify_report(path, RunSnapshot.find(atlas or _atlas_around(path)), **options)


def _atlas_around(path: Path) -> str:
    """Return the folder of the run whose adaptation is in a file."""
    folder = path.absolute().parent
    if folder.name != ADAPTATIONS or not holds_run(folder.parent):
        raise GaitsimError(
            f"{path} does not say where its atlas is",
            where="--atlas",
            remedy="name the run of the atlas, such as --atlas spider-atlas",
        )
    return os.path.relpath(folder.parent)


# Unlike pathlib, os.path accepts names that are invalid for files.
ADAPTATIONS_OF_ATLASES = Verifier(
    lambda path: path.suffix == ".json" and os.path.isfile(path),  # noqa: PTH113
    _verify_adaptation,
)
REPORTS = Verifier(lambda path: os.path.lexists(path / FILE), _verify_report)
