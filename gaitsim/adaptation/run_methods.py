"""The methods of a run that adapt its gaits, for Python."""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from gaitsim.adaptation.adaptation import Adaptation, open_adaptation
from gaitsim.adaptation.report import AdaptationReport, make_report
from gaitsim.adaptation.settings import AdaptationSettings
from gaitsim.adaptation.trials import MeasureGait
from gaitsim.runs.snapshot import RunSnapshot


class _HasSnapshot(Protocol):
    @property
    def snapshot(self) -> RunSnapshot: ...


class RunAdaptations:
    """A run on disk, with the methods that adapt its gaits."""

    def adapt(
        self: _HasSnapshot,
        damage: Sequence[str] = (),
        *,
        physics: bool = False,
        robot: MeasureGait | None = None,
        measure: str | None = None,
        trials: int | None = None,
        kappa: float | None = None,
        length_scale: float | None = None,
        noise: float | None = None,
        stop: float | None = None,
        name: str | None = None,
        fresh: bool = False,
        workers: int | None = None,
    ) -> Adaptation:
        """Return an adaptation, an iterator that performs the same trials as `gaitsim adapt`.

        Args:
            damage: damaged legs and joints of the simulated body, such as 'L2 lost'.
            physics: whether the trials take place on the body's twin, its version in rigid-body
                physics.
            robot: function that plays an individual on your robot and returns its performance.
                Without `robot`, damage or physics, you record each trial with `record()`.
            measure: name of the performance measure, where more is better; None for the measure in
                the file, or 'forward'.
            trials: maximum number of trials. For this and the next four arguments, None keeps the
                value in the file, or the default of `gaitsim.adaptation.Settings`.
            kappa: weight of the uncertainty in the choice of a trial.
            length_scale: distance over which a trial affects the expected performance of other
                gaits, relative to the ranges of the axes.
            noise: variance of a measured performance, where the best in the map is 1.
            stop: share of the best expected performance that a trial must reach to end the
                adaptation.
            name: name of the file that stores the trials, so that the same call continues them;
                None stores nothing.
            fresh: whether to start over and replace that file.
            workers: number of workers that evaluate the map; None for a number that suits the
                body.

        Raises:
            GaitsimError: the body does not support the damage, a setting is invalid, the body does
                not have the measure, or `robot` is combined with damage or physics.
            RunError: the run is not an atlas, or the file is damaged or belongs to a different
                adaptation.
        """
        given = {
            "trials": trials,
            "kappa": kappa,
            "length_scale": length_scale,
            "noise": noise,
            "stop": stop,
        }
        return open_adaptation(
            self.snapshot,
            damage,
            place="physics" if physics else "simulation" if damage else "robot",
            robot=robot,
            measure=measure,
            settings={key: value for key, value in given.items() if value is not None},
            record=name is not None,
            name=name,
            fresh=fresh,
            workers=workers,
        )

    def adaptation_report(
        self: _HasSnapshot,
        folder: str | Path,
        *,
        pairs: bool = False,
        physics: bool = False,
        settings: AdaptationSettings | None = None,
        workers: int | None = None,
    ) -> AdaptationReport:
        """Adapt to the loss of each leg like `gaitsim adapt --report`, or continue a report.

        Args:
            folder: folder of the report, which stores all trials in `report.json`.
            pairs: whether to also adapt to the loss of each pair of legs.
            physics: whether to use the body's twin, its version in rigid-body physics.
            settings: settings of the adaptations; None for the defaults of `gaitsim adapt`.
            workers: number of gaits tried at a time; None for the number of cores.

        Raises:
            GaitsimError: the body cannot lose legs, or has no twin.
            RunError: the run is not an atlas, the folder contains a different report, or the folder
                cannot be written.
        """
        return make_report(
            self.snapshot,
            Path(folder),
            pairs=pairs,
            physics=physics,
            settings=settings,
            workers=workers,
        )
