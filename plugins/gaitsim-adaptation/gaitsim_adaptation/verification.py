"""Verify adaptations: trials follow from the atlas, the settings and the measured values."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

from gaitsim.plugin import RunError, read_regular
from gaitsim.plugin.runs import CHECKPOINT, Account, FilesVerdict, RunSnapshot, command, cores
from gaitsim_adaptation.adaptation import check_gaits, read_session, trials_of
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
from gaitsim_adaptation.report import (
    FILE,
    SUMMARY,
    TRIALS,
    AdaptationReport,
    Case,
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
    ending,
    fit,
    individual_of,
    measure_intact,
    proposal_of,
    right_proposal,
    simulated_robot,
    transfer_map,
)

SAMPLES = 10
"""Number of cases of a report whose trials are measured again by default."""

LARGEST = 100_000_000  # bytes of a table or summary
OTHER_ATLAS = "it belongs to another atlas, or to an earlier generation of this one"


def verify_adaptation(
    file: Path,
    run: RunSnapshot,
    *,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: OnProgress = lambda done: None,
) -> FilesVerdict:
    """Compute the proposals of an adaptation again, and measure its trials in simulation again.

    Args:
        file: file of the adaptation.
        run: run of the atlas.
        workers: number of workers that evaluate the atlas; None for a number that suits the body.
        begin: callback with the number of gaits and trials to evaluate.
        advance: callback with the number of them evaluated since the last call.
    """
    session, members = read_session(file), atlas_members(run)
    if session is None:
        raise RunError(f"there is no adaptation {file}")
    said, simulated, physics = session.said, session.place != "robot", session.place == "physics"
    found, again = [OTHER_ATLAS], False
    if session.atlas == atlas_checksum(members):
        check_gaits(file, session, run.experiment_at(run.generation), len(members.scores))
        known = session.damage if session.known else ()
        begin(len(members.scores) * (1 + bool(known)) + len(session.intact) + simulated * len(said))
        prior = read_prior(
            run, session.measure, known, cached=False, workers=workers, on_progress=advance
        )
        found, again = intact_differences(run, prior, known), simulated
        if physics:
            robot = simulated_robot(prior.experiment, (), session.measure, physics=True)
            with ThreadPoolExecutor(workers or cores(), "gaitsim") as pool:
                intact = measure_intact(run, prior, robot, pool, advance, cached=False)
            found += _intact_differences(session.intact, intact)
            prior = transfer_map(prior, session.intact)
        for at, one in enumerate(said):
            if one.proposal is not None:
                before = trials_of(said[:at])
                found += _wrong_proposal(prior, before, session.settings, one.proposal)
        if simulated:
            robot = simulated_robot(
                prior.experiment, session.damage, session.measure, physics=physics
            )
            for one in said:
                measured = robot(individual_of(prior, session.trials[one.trial - 1]))
                if {*one.values} != {measured}:
                    found.append(_wrong_measurement(one.trial, one.values, measured))
                advance(1)
    count = len(session.trials)
    rows = [
        Account(
            file.name,
            f"{count} proposals computed again" + ", and measured" * simulated,
            "whether there were more trials" + "; the results of the robot" * (not simulated),
        )
    ]
    cache = intact_file(run.path, session.measure)
    if cache.exists():
        rows.append(Account(cache.name, "all gaits of the atlas evaluated again"))
    return FilesVerdict(
        "adaptation",
        "trials measured",
        count,
        tuple(range(1, count + 1)) if again else (),
        again,
        tuple(found),
        (*rows, _account_of_atlas(run)),
    )


def verify_report(
    folder: Path,
    run: RunSnapshot,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: OnProgress = lambda done: None,
) -> FilesVerdict:
    """Compute the proposals and the tables of a report again, and measure its cases again.

    Args:
        folder: folder of the report.
        run: run of the atlas.
        everything: whether to measure all cases again, rather than `SAMPLES`.
        workers: number of gaits tried at a time; None for the number of cores.
        begin: callback with the number of gaits and cases to evaluate.
        advance: callback with the number of them evaluated since the last call.
    """
    members = atlas_members(run)
    report = read_report(folder / FILE, len(members.scores))
    if report is None:
        raise RunError(f"there is no report {folder / FILE}")
    number = len(report.cases)
    count = number if everything else min(SAMPLES, number)
    chosen = np.linspace(0, max(number - 1, 0), count).round().astype(int).tolist()
    found, finished = [OTHER_ATLAS], (folder / SUMMARY).exists()
    if report.atlas == atlas_checksum(members):
        begin(len(members.scores) + len(report.intact) + len(chosen))
        prior = read_prior(run, report.measure, cached=False, workers=workers, on_progress=advance)
        found = _wrong_cases(run, prior, report, chosen, workers, advance)
        if finished and not found:
            found = _wrong_files(folder, prior, report)
    else:
        chosen = []
    rest = number - len(chosen)
    unknown = [f"the measured values of {rest} cases"] if rest else []
    if report.reference and report.reference.run:
        unknown.append(f"how far the champion of {report.reference.run} walks")
    rows = [
        Account(
            FILE,
            f"all proposals computed again; {len(chosen)} of {number} cases measured again",
            "; ".join(unknown),
        )
    ]
    if finished:
        rows += [
            Account(f"{TRIALS}, {SUMMARY}", f"computed again from {FILE}", "name of the atlas"),
            Account(", ".join(figure_names(report)), "not compared", f"whether they show {TRIALS}"),
        ]
    return FilesVerdict(
        "adaptation report",
        "cases measured",
        number,
        tuple(at + 1 for at in chosen),
        finished and not rest,
        tuple(found),
        (*rows, _account_of_atlas(run)),
        () if finished else (f"the report is not finished: it has no {SUMMARY} to compare",),
    )


def _account_of_atlas(run: RunSnapshot) -> Account:
    return Account(
        f"{run.path.resolve().name}/{CHECKPOINT}",
        "compared with the checksum of the atlas",
        f"how it evolved: {command('verify', run.path)}",
    )


def _wrong_cases(
    run: RunSnapshot,
    prior: Prior,
    report: AdaptationReport,
    chosen: Sequence[int],
    workers: int | None,
    advance: OnProgress,
) -> list[str]:
    """Return the differences of a report's cases, of which the chosen ones are measured again."""
    cases, every = report.cases, leg_losses(prior.experiment, pairs=True)
    damages = [case.damage for case in cases]
    if len({*damages}) < len(damages) or not {*damages} <= {*every}:
        return ["a case is there twice, or is not the loss of one or two legs"]
    if not all(fit(prior.experiment, case.trials) for case in cases):
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
    if report.place == "physics":
        prior = transfer_map(prior, report.intact)
    measured = {case.damage: case for case in again.cases}
    once = replace(report.settings, repeats=0)
    for case in cases:
        parts = [case.trials[:at] for at in range(len(case.trials) + 1)]
        wrong = []
        for before, trial in zip(parts, case.trials, strict=False):
            wrong += _wrong_proposal(prior, before, once, proposal_of(trial))
        ended = [bool(ending(prior, part, once)) for part in parts]
        if ended != [False] * len(case.trials) + [True]:
            wrong.append("trials are missing, or follow the end")
        if not wrong and measured.get(case.damage, case) != case:
            wrong = [*_wrong_measurements(case, measured[case.damage])]
        found += [f"{case.name}: {text}" for text in wrong]
    return found


def _wrong_measurements(case: Case, again: Case) -> Iterator[str]:
    """Yield the differences of the measured values of a case."""
    for then, now in zip(case.trials, again.trials, strict=False):
        if then != now:
            yield _wrong_measurement(then.number, (then.measured,), now.measured)
    if case.random != again.random:
        yield "the results of the random gaits differ"


def _wrong_files(folder: Path, prior: Prior, report: AdaptationReport) -> list[str]:
    """Return the tables of a finished report that do not follow from it."""
    text, table = _read(folder / SUMMARY), _read(folder / TRIALS)
    name = text.partition("\n")[0].removeprefix("# ").removesuffix(": adaptation to damage")
    known = {case.damage: case for case in report.cases}
    for pairs in (False, True):  # a report may have been repeated without its pairs
        damages = leg_losses(prior.experiment, pairs=pairs)
        if {*damages} <= {*known}:
            part = replace(report, cases=tuple(known[damage] for damage in damages))
            written = summary(part, name, figure_names(part)), trials_table(part)
            if written == (text, table):
                return []
    return [f"{TRIALS} or {SUMMARY} does not follow from {FILE}"]


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
    if proposal == right:
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
