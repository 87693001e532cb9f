"""Print an adaptation: its trials, the gait to try and the result; report on all leg losses."""

import sys
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.commands import (
    INTERRUPTED,
    Progress,
    echo,
    interruptible,
    notice,
    output,
    print_json,
    report_files,
)
from gaitsim.plugin.gait import analyse_individual
from gaitsim.plugin.pictures import save
from gaitsim.plugin.runs import RunSnapshot, command, write_bytes
from gaitsim.plugin.toolkit import damage_options
from gaitsim_adaptation.adaptation import Adaptation, Reply
from gaitsim_adaptation.plots import kept_figure, pairs_figure
from gaitsim_adaptation.report import (
    SUMMARY,
    TRIALS,
    AdaptationReport,
    make_report,
    summary,
    trials_table,
)
from gaitsim_adaptation.settings import AdaptationSettings
from gaitsim_adaptation.trials import Proposal, Trial, count_gaits


class AdaptationView:
    """Print an adaptation as lines for people, or as JSON lines for programs.

    Args:
        adaptation: adaptation to print.
        json: whether to print JSON lines.
    """

    def __init__(self, adaptation: Adaptation, json: bool) -> None:
        self._adaptation, self._json = adaptation, json
        prior, reference = adaptation.prior, adaptation.reference
        self._unit = f" {prior.unit}".rstrip()
        if json:
            return
        damage = ", ".join(adaptation.damage) or "no damage"
        body = {
            "simulation": f"a body with {damage}",
            "physics": f"the twin in physics with {damage}",
            "robot": f"your robot with {damage}" if adaptation.damage else "your robot",
        }[adaptation.place]
        output().print(
            f"{prior.source}: {len(prior.performance):,} gaits to try on {body}; "
            f"best {prior.measure} in the atlas: {prior.best:.3g}{self._unit}"
            + (f", of the champion: {reference.performance:.3g}{self._unit}" if reference else ""),
            style="bold",
        )

    def print_all(self, trials: Iterable[Trial]) -> None:
        """Print the earlier trials, and new trials as they finish."""
        self.print_earlier()
        for trial in trials:
            self.print_trial(trial)

    def print_earlier(self) -> None:
        """Print the trials so far."""
        for trial in self._adaptation.trials:
            self.print_trial(trial)

    def print_trial(self, trial: Trial) -> None:
        """Print a trial."""
        if self._json:
            print_json({"trial": trial.number, **_values(trial)})
            return
        echo(f"{self._prediction(trial)}, {describe_result(trial)}{self._unit}")

    def print_done(self, reply: Reply, trial: Trial) -> None:
        """Print the trial that a reply added, changed or removed."""
        if reply.kind != "undo":
            self.print_trial(trial)
        elif self._json:
            print_json({"undone": trial.number, **_values(trial)})
        else:
            echo(f"removed trial {trial.number}, {describe_result(trial)}{self._unit}")

    def print_proposal(self, proposal: Proposal, file: Path) -> None:
        """Print a gait to try, and its file."""
        if self._json:
            print_json({"proposal": proposal.number, **_values(proposal), "file": str(file)})
            return
        echo(f"{self._prediction(proposal)}\n  play {file}")

    def print_result(self, file: Path | None = None) -> None:
        """Print why the adaptation has ended, its best gait, and commands to use it.

        Args:
            file: gait file of the best gait, if it is not a member of the atlas.
        """
        adaptation = self._adaptation
        best, gait, prior = adaptation.best, adaptation.gait, adaptation.prior
        if best is None or gait is None:
            raise ValueError("an adaptation cannot end without a trial")
        name = analyse_individual(gait).name.name
        if self._json:
            shares = {"share": best.measured / prior.best}
            if adaptation.reference is not None:
                whole = adaptation.reference.performance
                shares |= {"champion": whole, "share_of_champion": best.measured / whole}
            values = {"member": best.member, "gait": name, "measured": best.measured}
            path = str(adaptation.path) if adaptation.path else None
            ended = {"ended": adaptation.ending, "trials": len(adaptation.trials)}
            values |= {"genome": [*best.genome], "file": str(file)} if file else {}
            print_json({**ended, **values, **shares, "adaptation": path})
            return
        echo(f"Ended: {adaptation.ending}.")
        gait_words = "an unnamed gait" if name == "none" else f"{name} in the atlas"
        output().print(
            f"Best: {_of(best)}, {gait_words}: {adaptation.shares}",
            style="bold",
        )
        damage = damage_options(adaptation.damage)
        chosen = (prior.source, *(("--gait", file) if file else ("--member", best.member)))
        commands = {
            "watch it": command("play", *chosen, *damage),
            "export it": command("export", *chosen),
            "make a video": command("video", *chosen, *damage),
        }
        if adaptation.place == "physics":
            commands["analyse it in physics"] = command("analyse", *chosen, *damage, "--physics")
        for meaning, line in commands.items():
            output().print(f"  {line}  # {meaning}", style="dim")

    def _prediction(self, one: Proposal) -> str:
        return (
            f"trial {one.number:>2}  {_of(one)}  expected {one.expected:6.3f} ± "
            f"{one.deviation:.3f}{self._unit}"
        )


def describe_result(trial: Trial) -> str:
    """Return the result of a trial, such as 'fell, measured 0.300'."""
    outcome = "" if trial.outcome == "walked" else f"{trial.outcome}, "
    several = f"mean of {len(trial.values)} " if len(trial.values) > 1 else ""
    return f"{outcome}measured {several}{trial.measured:.3f}"


def _of(proposal: Proposal) -> str:
    """Return the gait of a proposal, such as 'member 2647'."""
    return f"{'change' if proposal.genome else 'member'} {proposal.member:>6}"


def _values(one: Proposal) -> dict[str, Any]:
    """Return a proposal or a trial as values for JSON, without its number."""
    values: dict[str, Any] = {
        "member": one.member,
        "expected": one.expected,
        "deviation": one.deviation,
    }
    if one.genome:
        values["genome"] = one.genome
    if isinstance(one, Trial):
        values["measured"] = one.measured
        if len(one.values) > 1:
            values |= {"lowest": one.lowest, "count": len(one.values)}
        if len(one.values) > 1 or one.outcome != "walked":
            values["outcome"] = one.outcome
    return values


def write_report(
    run: RunSnapshot,
    folder: Path | None,
    settings: Mapping[str, Any],
    *,
    supported: bool,
    **options: Any,
) -> None:
    """Compute or continue a report on an atlas, and write its files.

    Args:
        run: the atlas.
        folder: folder of the report; None if the command line lacks it.
        settings: settings of the adaptations, fields of `AdaptationSettings` by name.
        supported: whether a report supports all options of the command line.
        options: options of `make_report`.
    """
    if folder is None:
        raise GaitsimError("--pairs needs --report FOLDER", where="--pairs")
    if not supported:
        raise GaitsimError(
            "--report covers all leg losses, so only some options can be combined with it",
            where="--report",
            allowed="--pairs, --physics, --measure, --champion, --workers, and the options under "
            "'How trials are chosen'",
        )
    try:
        with interruptible():
            _write(_compute(run, folder, settings, **options), run.path.resolve().name, folder)
    except KeyboardInterrupt:
        notice("Stopped; finished adaptations are saved. Repeat the command to continue.")
        sys.exit(INTERRUPTED)


def _compute(
    run: RunSnapshot, folder: Path, settings: Mapping[str, Any], **options: Any
) -> AdaptationReport:
    gaits = count_gaits(run, physics=options["physics"])
    with ExitStack() as bars:

        def bar(what: str, unit: str, total: int) -> Progress:
            bars.close()
            return bars.enter_context(Progress(what, unit, total, log=f"{what}: {total:,} {unit}"))

        adapting: list[Progress] = []

        def on_case(done: int, total: int) -> None:
            if not adapting:
                adapting.append(bar("adapting", "damages", total))
            adapting[0].reach(done)

        return make_report(
            run,
            folder,
            settings=AdaptationSettings(**settings),
            on_atlas=bar("evaluating the atlas", "gaits", gaits).advance,
            on_case=on_case,
            **options,
        )


def _write(report: AdaptationReport, name: str, folder: Path) -> None:
    heading = f"{name}, {'physics' if report.place == 'physics' else 'simulation'}"
    figures = {"kept.svg": kept_figure}
    if any(len(case.damage) == 2 for case in report.cases):
        figures["pairs.svg"] = pairs_figure
    for file, draw in figures.items():
        save(draw(report, heading), folder / file)
    text = summary(report, name, [*figures])
    write_bytes(folder / TRIALS, trials_table(report).encode())
    write_bytes(folder / SUMMARY, text.encode())
    echo(text.split("\n\n!")[0].rstrip())
    report_files(folder)
