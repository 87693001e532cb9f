"""Settings of the trials on a damaged body."""

from dataclasses import dataclass

from gaitsim.plugin import GaitsimError

MOST_TRIALS = 1000
_LOWEST = {"kappa": 0, "length_scale": 1e-3, "noise": 1e-9, "stop": 0, "scale": 1e-3}


@dataclass(frozen=True)
class AdaptationSettings:
    """The settings of an adaptation.

    Performance is relative to the best in the map, and distances between behaviours are relative to
    the ranges of the axes.

    Source: Cully, Clune, Tarapore and Mouret 2015, "Robots that can adapt like animals", who use
    six axes, a length scale of 0.4 and a stop at 0.9. For the spider's eight axes, a shorter length
    scale works better.

    Attributes:
        trials: maximum number of trials.
        kappa: weight of the uncertainty in the choice of a trial; 0 always tries the gait with
            the best expected performance.
        length_scale: distance over which a trial affects the expected performance of other gaits.
        noise: variance of a measured performance.
        stop: share of the best expected performance that a trial must reach to end the trials of
            the map.
        scale: performance of the intact body as a share of the map; None estimates it from the
            trials.
        refine: number of changed gaits that are tried after those of the map; see `refinement`.
        repeats: how often the best gait is measured again after the changed gaits.
    """

    trials: int = 20
    kappa: float = 0.05
    length_scale: float = 0.2
    noise: float = 0.001
    stop: float = 0.95
    scale: float | None = 1.0
    refine: int = 0
    repeats: int = 0

    def __post_init__(self) -> None:
        whole = {"trials": 1, "refine": 0, "repeats": 0}
        for name, low in {**whole, **_LOWEST}.items():
            value, high = getattr(self, name), MOST_TRIALS if name in whole else 1e3
            kind = int if name in whole else int | float
            if name == "scale" and value is None:
                continue
            if not (isinstance(value, kind) and low <= value <= high):
                raise GaitsimError(
                    f"invalid {name!r} for an adaptation: {value!r:.80}",
                    key=name,
                    allowed=f"{'a whole number' if kind is int else 'a number'}, {low} to {high:g}",
                )
