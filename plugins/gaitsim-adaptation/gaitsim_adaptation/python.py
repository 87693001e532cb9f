"""`gs.adapt` and `gs.adaptation_report`."""

from collections.abc import Sequence
from pathlib import Path

from gaitsim.plugin.runs import Run, RunSnapshot
from gaitsim_adaptation.adaptation import Adaptation, measured_scale, open_adaptation
from gaitsim_adaptation.report import AdaptationReport, make_report
from gaitsim_adaptation.settings import AdaptationSettings
from gaitsim_adaptation.trials import MeasureGait


def adapt(
    run: Run | Path | str,
    damage: Sequence[str] | None = None,
    *,
    physics: bool = False,
    visible: bool = False,
    robot: MeasureGait | bool | None = None,
    scale: float | str | None = None,
    measure: str | None = None,
    trials: int | None = None,
    refine: int | None = None,
    kappa: float | None = None,
    length_scale: float | None = None,
    noise: float | None = None,
    stop: float | None = None,
    name: str | None = None,
    fresh: bool = False,
    champion: str | None = None,
    workers: int | None = None,
) -> Adaptation:
    """Return an adaptation, an iterator that performs the same trials as `gaitsim adapt`.

    Args:
        run: the atlas: a run of Python, its folder or its name.
        damage: damaged legs and joints, such as 'L2 lost', of the simulated body; for a robot,
            the damage that you see, which improves the predictions.
        physics: whether the trials take place on the body's twin, its version in rigid-body
            physics.
        visible: whether the damage to the body in simulation also serves the predictions.
        robot: function that plays an individual on your robot and returns its performance. With
            True, or without `robot`, damage and physics, you record each trial with `record()`.
        scale: performance of the intact robot as a share of that in simulation, or the name of
            trials on the intact robot; None estimates it from the trials.
        measure: name of the performance measure, where more is better; None for the measure in
            the file, or 'forward'.
        trials: maximum number of trials. For this and the next five arguments, None keeps the
            value in the file, or the default of `AdaptationSettings`.
        refine: number of small changes of the best gait to try after the gaits of the atlas.
        kappa: weight of the uncertainty in the choice of a trial.
        length_scale: distance over which a trial affects the expected performance of other
            gaits, relative to the ranges of the axes.
        noise: variance of a measured performance, where the best in the map is 1.
        stop: share of the best expected performance that a trial must reach to end the
            adaptation.
        name: name of the file that stores the trials, so that the same call continues them;
            None stores nothing.
        fresh: whether to start over and replace that file.
        champion: run whose champion on the intact body is the `reference`; None for the
            champion from which the atlas began.
        workers: number of workers that evaluate the map; None for a number that suits the
            body.

    Raises:
        GaitsimError: the body does not support the damage, a setting is invalid, the body does
            not have the measure, or `robot` is combined with physics.
        RunError: the run is not an atlas, or the file is damaged or belongs to a different
            adaptation.
    """
    atlas = _snapshot(run)
    if isinstance(scale, str):
        scale = measured_scale(atlas, scale)
    given = {
        "trials": trials,
        "refine": refine,
        "scale": scale,
        "kappa": kappa,
        "length_scale": length_scale,
        "noise": noise,
        "stop": stop,
    }
    return open_adaptation(
        atlas,
        damage,
        place="physics" if physics else "robot" if robot or not damage else "simulation",
        robot=robot if callable(robot) else None,
        known=visible,
        measure=measure,
        settings={key: value for key, value in given.items() if value is not None},
        saved=name is not None,
        name=name,
        fresh=fresh,
        champion=champion,
        workers=workers,
    )


def adaptation_report(
    run: Run | Path | str,
    folder: str | Path,
    *,
    pairs: bool = False,
    physics: bool = False,
    settings: AdaptationSettings | None = None,
    champion: str | None = None,
    workers: int | None = None,
) -> AdaptationReport:
    """Adapt to the loss of each leg like `gaitsim adapt --report`, or continue a report.

    Args:
        run: the atlas: a run of Python, its folder or its name.
        folder: folder of the report, which stores all trials in `report.json`.
        pairs: whether to also adapt to the loss of each pair of legs.
        physics: whether to use the body's twin, its version in rigid-body physics.
        settings: settings of the adaptations; None for the defaults of `gaitsim adapt`.
        champion: run of the champion to compare with, as in `adapt`.
        workers: number of gaits tried at a time; None for the number of cores.

    Raises:
        GaitsimError: the body cannot lose legs, or has no twin.
        RunError: the run is not an atlas, the folder contains a different report, or the folder
            cannot be written.
    """
    return make_report(
        _snapshot(run),
        Path(folder),
        pairs=pairs,
        physics=physics,
        settings=settings,
        champion=champion,
        workers=workers,
    )


def _snapshot(run: Run | Path | str) -> RunSnapshot:
    return run.snapshot if isinstance(run, Run) else RunSnapshot.find(str(run))
