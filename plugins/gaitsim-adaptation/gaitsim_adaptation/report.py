"""Adaptations to the loss of legs, compared with the unadapted champion and with random gaits."""

import statistics
import threading
import zlib
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import ClassVar

import numpy as np
from pydantic import ConfigDict, TypeAdapter, ValidationError

from gaitsim.plugin import GaitsimError, RunError, read_regular
from gaitsim.plugin.runs import (
    EXACT_KEYS,
    LARGEST_SCORE,
    Experiment,
    Individual,
    RunSnapshot,
    cores,
    first_problem,
    table_line as line,
    write_bytes,
    writing,
)
from gaitsim_adaptation.adaptation import Adaptation
from gaitsim_adaptation.champion import Reference, find_reference
from gaitsim_adaptation.prior import (
    DEFAULT_MEASURE,
    OnProgress,
    Prior,
    atlas_checksum,
    atlas_members,
    read_prior,
)
from gaitsim_adaptation.record import Place
from gaitsim_adaptation.settings import AdaptationSettings
from gaitsim_adaptation.trials import (
    MeasureGait,
    Trial,
    best_of,
    measure_intact,
    most_promising,
    simulated_robot,
    transfer_map,
)

FILE = "report.json"
_LARGEST = 100_000_000  # bytes

OnSteps = Callable[[int, int], object]
"""Called with the number of finished steps and the number of all steps."""


@dataclass(frozen=True)
class Case:
    """The adaptation to one case of damage.

    Attributes:
        damage: damage to the body, such as ('L1 lost', 'L2 lost').
        trials: trials in order. The first is the map's best gait, the champion.
        random: measured performance of gaits drawn at random from the map, one for each trial.
    """

    damage: tuple[str, ...]
    trials: tuple[Trial, ...]
    random: tuple[float, ...]

    @property
    def name(self) -> str:
        """Short description of the damage, such as 'L1 + L2' for lost legs."""
        return " + ".join(text.removesuffix(" lost") for text in self.damage)

    @property
    def best(self) -> Trial:
        """Trial with the best measured performance."""
        best = best_of(self.trials)
        if best is None:
            raise ValueError("a case has at least one trial")
        return best

    @property
    def champion(self) -> float:
        """Measured performance of the map's best gait, without adaptation."""
        return self.trials[0].measured


@dataclass(frozen=True)
class AdaptationReport:
    """Adaptations of one atlas to different damage.

    Attributes:
        atlas: checksum of the atlas's members.
        place: place of the trials.
        measure: name of the performance measure.
        unit: unit of that measure.
        settings: settings of the adaptations.
        intact: measured performance of the most promising gaits on the intact body, by member.
        cases: finished adaptations.
        reference: the champion of a run, on the intact body; None without one.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    atlas: str
    place: Place
    measure: str
    unit: str
    settings: AdaptationSettings
    intact: dict[int, float]
    cases: tuple[Case, ...] = ()
    reference: Reference | None = None

    @property
    def best(self) -> float:
        """Best measured performance on the intact body."""
        return max(self.intact.values())

    def kept(self, measured: float) -> float:
        """Return a performance as a share of the best on the intact body."""
        return measured / self.best


_REPORT = TypeAdapter(AdaptationReport)


def leg_losses(experiment: Experiment, *, pairs: bool = False) -> list[tuple[str, ...]]:
    """Return the loss of each leg, and with `pairs` also of each pair of legs."""
    legs = [*experiment.organism.leg_joints()]
    if len(legs) < 3:
        raise GaitsimError(
            f"{experiment.entries['organism']} has {len(legs)} legs",
            allowed="a body with at least three legs",
        )
    lost = [f"{leg} lost" for leg in legs]
    return [*combinations(lost, 1), *(combinations(lost, 2) if pairs else ())]


def make_report(
    run: RunSnapshot,
    folder: Path,
    *,
    pairs: bool = False,
    physics: bool = False,
    measure: str = DEFAULT_MEASURE,
    settings: AdaptationSettings | None = None,
    champion: str | None = None,
    workers: int | None = None,
    on_atlas: OnProgress = lambda done: None,
    on_case: OnSteps = lambda done, total: None,
) -> AdaptationReport:
    """Adapt an atlas to the loss of each leg, or continue the report in the folder.

    In physics, the most promising gaits are first measured on the intact body in rigid-body
    physics, and these measurements correct the map. The adaptations run in parallel; their order
    does not change the result.

    Args:
        run: run of the atlas.
        folder: folder of the report, which stores all measurements in `report.json`.
        pairs: whether to also adapt to the loss of each pair of legs.
        physics: whether to use the body's twin, its version in rigid-body physics.
        measure: name of the performance measure.
        settings: settings of the adaptations; None for the defaults.
        champion: run of the champion to compare with; see `find_reference`.
        workers: number of gaits tried at a time; None for the number of cores.
        on_atlas: called with the number of gaits measured on the intact body since the last call.
        on_case: called whenever a case finishes.
    """
    reference = find_reference(run, champion, measure, physics=physics)
    prior = read_prior(run, measure, workers=workers, on_progress=on_atlas)
    damages, path = leg_losses(prior.experiment, pairs=pairs), folder / FILE
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    wanted = AdaptationReport(
        atlas_checksum(atlas_members(run)),
        "physics" if physics else "simulation",
        measure,
        prior.unit,
        settings or AdaptationSettings(),
        {},
    )
    found = read_report(path, len(prior.genomes))
    if found and replace(found, intact={}, cases=(), reference=None) != wanted:
        raise RunError(
            f"{path} contains a report on a different atlas or with different options",
            remedy=_REMEDY,
        )
    report = replace(found or wanted, reference=reference)
    if found and found != report:
        _write(path, report)
    stopped = threading.Event()

    def stoppable_robot(damage: Sequence[str]) -> MeasureGait:
        robot = simulated_robot(prior.experiment, damage, measure, physics=physics)

        def measure_gait(individual: Individual) -> float:
            if stopped.is_set():
                raise _StoppedError
            return robot(individual)

        return measure_gait

    with ThreadPoolExecutor(workers or cores(), "gaitsim") as pool:
        try:
            if not report.intact:
                intact = {most_promising(prior, 1)[0]: prior.best}
                if physics:
                    intact = measure_intact(run, prior, stoppable_robot(()), pool, on_atlas)
                report = replace(report, intact=intact)
                _write(path, report)
            if physics:
                prior = transfer_map(prior, report.intact)
            known = {case.damage: case for case in report.cases}
            missing = [damage for damage in damages if damage not in known]
            on_case(len(damages) - len(missing), len(damages))
            adapting = [
                pool.submit(
                    _adapt_to_damage, prior, damage, stoppable_robot(damage), report.settings
                )
                for damage in missing
            ]
            for done in as_completed(adapting):
                known[done.result().damage] = done.result()
                ordered = [*filter(known.__contains__, damages), *(known.keys() - {*damages})]
                report = replace(report, cases=tuple(known[damage] for damage in ordered))
                _write(path, report)
                on_case(len(known), len({*damages, *known}))
        finally:
            stopped.set()
            pool.shutdown(cancel_futures=True)
    return replace(report, cases=tuple(known[damage] for damage in damages))


class _StoppedError(Exception):
    """Raised to stop the remaining trials of an interrupted report."""


def _adapt_to_damage(
    prior: Prior, damage: tuple[str, ...], measure_gait: MeasureGait, settings: AdaptationSettings
) -> Case:
    once = replace(settings, repeats=0)
    trials = tuple(Adaptation.unsaved(prior, measure_gait, once))
    rng = np.random.default_rng(zlib.crc32(" ".join(damage).encode()))
    drawn = rng.choice(len(prior.performance), len(trials), replace=False)
    random = tuple(measure_gait(prior.individual(int(index) + 1)) for index in drawn)
    return Case(damage, trials, random)


_REMEDY = "delete the file, or choose a different folder"


def read_report(path: Path, members: int) -> AdaptationReport | None:
    """Return the report in a file on an atlas of `members` members; None if there is none."""
    try:
        data = read_regular(path, _LARGEST)
        found = _REPORT.validate_json(data)
        reason = _inconsistency(found, members)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}", remedy=_REMEDY) from None
    except ValidationError as error:
        if b'"measured": ' in data:
            what = f"{path} was written by an older version of gaitsim"
            raise RunError(what, remedy=_REMEDY) from None
        key, what = first_problem(error, "report")
        raise RunError(f"{path} is damaged: {key}: {what}", remedy=_REMEDY) from None
    except GaitsimError as error:  # invalid settings
        raise RunError(f"{path} is damaged: {error.what}", remedy=_REMEDY) from None
    if reason:
        raise RunError(f"{path} is damaged: {reason}", remedy=_REMEDY)
    return found


def _inconsistency(report: AdaptationReport, members: int) -> str:
    """Return why a report on an atlas of `members` members is inconsistent, or ''."""
    trials = [trial for case in report.cases for trial in case.trials]
    numbers = [*report.intact.values(), *(one for case in report.cases for one in case.random)]
    numbers += [one for trial in trials for one in (trial.expected, trial.deviation, *trial.values)]
    if not all(abs(number) < LARGEST_SCORE for number in numbers):
        return "a value is not a finite number"
    if not all(1 <= one <= members for one in (*report.intact, *(one.member for one in trials))):
        return "it contains members that the atlas does not have"
    if report.reference and not 0 < report.reference.performance < LARGEST_SCORE:
        return "its champion does not walk"
    if not max(report.intact.values(), default=0) > 0:
        return "it has no gait that walks on the intact body"
    if not all(trial.values for trial in trials):
        return "a trial has no value"
    if not all(len(case.trials) == len(case.random) > 0 for case in report.cases):
        return "a case has no trials"
    return ""


def _write(path: Path, report: AdaptationReport) -> None:
    write_bytes(path, _REPORT.dump_json(report, indent=1) + b"\n", follow=False)


TRIALS, SUMMARY = "trials.csv", "report.md"
_COLUMNS = (
    *("damage", "way", "trial", "member", "expected", "deviation", "measured", "kept"),
    "of champion",
)


def trials_table(report: AdaptationReport) -> str:
    """Return a CSV table with a row for each trial, followed by the random gaits of its case."""
    champion = report.reference

    def shares(measured: float) -> list[float | str]:
        return [report.kept(measured), measured / champion.performance if champion else ""]

    text = line(_COLUMNS)
    for case in report.cases:
        for trial in case.trials:
            text += line(
                [
                    case.name,
                    "adaptation",
                    trial.number,
                    trial.member,
                    trial.expected,
                    trial.deviation,
                    trial.measured,
                    *shares(trial.measured),
                ]
            )
        for number, measured in enumerate(case.random, 1):
            text += line([case.name, "random", number, "", "", "", measured, *shares(measured)])
    return text


def summary(report: AdaptationReport, source: str, figures: Sequence[str] = ()) -> str:
    """Return a summary of the report in Markdown.

    Args:
        report: the report, with all its cases.
        source: name of the atlas.
        figures: names of image files in the same folder, which are shown below the table.
    """
    where = "in rigid-body physics" if report.place == "physics" else "in simulation"
    measured = len(report.intact)
    unit = f" {report.unit}".rstrip()
    columns, meaning = ["kept", "champion", "random"], ""
    if report.reference is not None:
        run, whole = report.reference.run, f"{report.reference.performance:.3g}{unit}"
        columns.insert(0, f"of {whole}")
        which = f"of {run}" if run else "from which the atlas began"
        meaning = f" {whole}: the champion {which}, on the intact body."
    columns = ["damage", "trials", f"{report.measure}{unit and ','}{unit}", *columns]
    lines = [
        f"# {source}: adaptation to damage",
        "",
        f"Trials {where}. Best on the intact body: {report.best:.3g}{unit}"
        + (f", of the {measured} most promising gaits." if measured > 1 else "."),
        "The last three columns are shares of this value. Kept: the best gait found by adaptation. "
        "Champion: the map's best gait, without adaptation. Random: the best of as many "
        f"random gaits of the map as there were trials.{meaning}",
        "",
        f"| {' | '.join(columns)} |",
        f"|{' --- |' * len(columns)}",
    ]
    lines += [_row(report, case.name, [case]) for case in report.cases]
    for count in sorted({len(case.damage) for case in report.cases}):
        cases = [case for case in report.cases if len(case.damage) == count]
        words = "one leg" if count == 1 else f"{count} legs"
        lines.append(_row(report, f"**{words}, median of {len(cases)}**", cases))
    return "\n".join([*lines, "", *(f"![]({figure})" for figure in figures)]).rstrip() + "\n"


def _row(report: AdaptationReport, name: str, cases: Sequence[Case]) -> str:
    def median(value: Callable[[Case], float]) -> float:
        return statistics.median(map(value, cases))

    measured = median(lambda case: case.best.measured)
    shares = [
        report.kept(measured),
        median(lambda case: report.kept(case.champion)),
        median(lambda case: report.kept(max(case.random))),
    ]
    if report.reference is not None:
        shares.insert(0, measured / report.reference.performance)
    cells = [
        name,
        f"{median(lambda case: len(case.trials)):g}",
        f"{measured:.3g}",
        *(f"{one:.0%}" for one in shares),
    ]
    return f"| {' | '.join(cells)} |"
