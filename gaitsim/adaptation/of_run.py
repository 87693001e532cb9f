"""Adaptations of a run, for Python."""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from gaitsim.adaptation.adaptation import Adaptation, open_adaptation
from gaitsim.adaptation.report import Report, make_report
from gaitsim.adaptation.settings import Settings
from gaitsim.adaptation.trials import Measured
from gaitsim.runs.snapshot import RunSnapshot


class _HasSnapshot(Protocol):
    @property
    def snapshot(self) -> RunSnapshot: ...


class RunAdaptations:
    """A run on disk, with the method that adapts its gaits."""

    def adapt(
        self: _HasSnapshot,
        damage: Sequence[str] = (),
        *,
        physics: bool = False,
        robot: Measured | None = None,
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
        """Return an adaptation to loop over, an iterator of trials, as `gaitsim adapt` makes them.

        Args:
            damage: legs and joints of the simulated body, such as 'L2 lost'.
            physics: whether the trials are made on the physical twin of the body.
            robot: a function that plays an individual on a robot of yours and returns its
                performance; without it and without damage, `record()` the trials.
            measure: name of the measure that is the performance; more is better. None for forward.
            trials: the greatest number of trials. None, as for the next four, for the default of
                `gaitsim.adaptation.Settings`, or for that of the file.
            kappa: weight of the uncertainty in the choice of a trial.
            length_scale: distance over which a trial informs about other gaits, in shares of the
                axes' ranges.
            noise: variance of a measured performance, in shares of the map's best.
            stop: the trials end when the best one is this share of the best still expected.
            name: of the file that keeps the trials, by which the same call continues; None keeps
                none.
            fresh: whether to begin again in that file.
            workers: how many evaluate the map at a time; None for what suits the body.

        Raises:
            GaitsimError: the body cannot be damaged, or not like this; a setting is invalid; or
                the body has no such measure.
            RunError: the run is not an atlas; or the file is damaged, or of another adaptation.
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
        settings: Settings | None = None,
        workers: int | None = None,
    ) -> Report:
        """Adapt to the loss of each leg, as `gaitsim adapt --report` does; or continue a report.

        Args:
            folder: which keeps all trials in `report.json`.
            pairs: whether also to the loss of each two legs.
            physics: whether the physical twin of the body moves.
            settings: of the adaptations; None for those of `gaitsim adapt`.
            workers: how many gaits are tried at a time; None for as many as there are cores.

        Raises:
            GaitsimError: the body cannot lose legs, or has no twin.
            RunError: the run is not an atlas; or the folder has another report, or cannot be
                written.
        """
        return make_report(
            self.snapshot,
            Path(folder),
            pairs=pairs,
            physics=physics,
            settings=settings,
            workers=workers,
        )
