"""Verify adaptations: trials follow from the atlas, the settings and the measured values."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gaitsim.plugin import GaitsimError, RunError
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
from gaitsim_adaptation.settings import AdaptationSettings
from gaitsim_adaptation.trials import (
    Proposal,
    Trial,
    individual_of,
    measure_intact,
    right_proposal,
    simulated_robot,
    transfer_map,
)

OTHER_ATLAS = "it belongs to another atlas, or to an earlier generation of this one"


def verify_adaptation(
    file: Path,
    *,
    atlas: str | None,
    everything: bool,
    workers: int | None,
    begin: Callable[[int], None],
    advance: OnProgress,
) -> Verdict:
    """Compute the proposals of an adaptation again, and measure its trials in simulation again.

    Args:
        file: file of the adaptation.
        atlas: run of the atlas; None for the run whose folder contains the file.
        everything: unused, as all trials are always computed again.
        workers: number of workers that evaluate the atlas; None for a number that suits the body.
        begin: callback with the number of gaits and trials to evaluate.
        advance: callback with the number of them evaluated since the last call.
    """
    run = RunSnapshot.find(atlas or _atlas_around(file))
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
            if record.intact != intact:
                found.append("gaits on the intact body perform differently when measured again")
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
                    recorded = " and ".join(map(repr, one.values))
                    what = f"{recorded} was recorded, but {measured!r} is measured"
                    found.append(f"trial {one.number}: {what}")
                advance(1)
    count = len(trials)
    differences = [FileDifference(file.name, text) for text in found]
    differences += [FileDifference(cache.name, text) for text in cached]
    files = {}
    how = f"how the atlas evolved: {command('verify', run.path)}"
    unknown = {f"{run.path.resolve().name}/{CHECKPOINT}": how}
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
    verify_adaptation,
)
