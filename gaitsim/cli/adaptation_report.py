"""`gaitsim adapt --report`."""

import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from gaitsim.adaptation.report import (
    SUMMARY,
    TRIALS,
    AdaptationReport,
    make_report,
    summary,
    trials_table,
)
from gaitsim.adaptation.settings import AdaptationSettings
from gaitsim.adaptation.trials import count_intact_gaits
from gaitsim.console import INTERRUPTED
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import echo, notice, report_files
from gaitsim.console.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.render.plots.adaptation_report import kept_figure, pairs_figure
from gaitsim.render.plots.style import save
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.snapshot import RunSnapshot


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
            allowed="--pairs, --physics, --measure, --workers, and the options under "
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
    gaits = count_intact_gaits(run, physics=options["physics"])
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
    figures = {"kept.svg": kept_figure(report, heading)}
    if any(len(case.damage) == 2 for case in report.cases):
        figures["pairs.svg"] = pairs_figure(report, heading)
    text = summary(report, name, [*figures])
    for file, figure in figures.items():
        save(figure, folder / file)
    write_bytes(folder / TRIALS, trials_table(report).encode())
    write_bytes(folder / SUMMARY, text.encode())
    echo(text.split("\n\n!")[0].rstrip())
    report_files(folder)
