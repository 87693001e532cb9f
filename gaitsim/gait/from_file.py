"""Begin a search at a gait from a file: fit it to the encoding of a body."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.playing import play
from gaitsim.experiment import Experiment, with_overrides
from gaitsim.gait.gait_files import GaitFile, fit_to_body, play_gait
from gaitsim.individual import Individual
from gaitsim.legged import angles_frequency
from gaitsim.registry import plugin_errors
from gaitsim.toml import brief

REPEATS = 4
"""How often a gait is repeated in which no stride repeats, as one cycle."""


@dataclass(frozen=True, eq=False)
class FoundStart:
    """A gait from a file as a genome.

    Attributes:
        experiment: experiment with the options of the body with which the genome plays.
        individual: the genome, evaluated.
        about: a sentence for the user: how far it is from the file.
    """

    experiment: Experiment
    individual: Individual
    about: str


def start_from_gait(experiment: Experiment, file: GaitFile) -> FoundStart:
    """Return the gait of an experiment's body that is closest to a file's.

    Strides are found in the joint angles, and the last ones are fitted. A file in which no stride
    repeats is taken as one cycle.

    Raises:
        GaitsimError: the body cannot play the file, or has no method `fit_gait`.
    """
    organism, entry = experiment.organism, experiment.entries["organism"]
    angles = fit_to_body(file, experiment)
    rate = play(experiment, angles[None, :2]).frame_rate
    cycles = 1
    frequency = _frequency(angles, rate)
    if not frequency:
        file, cycles = file.repeated(REPEATS), REPEATS
        angles = fit_to_body(file, experiment)
        frequency = cycles * rate / (len(angles) - 1)
    strides = max(int(len(angles) / 2 / rate * frequency), 1)
    whole = angles[-min(round(strides / frequency * rate), len(angles)) :]
    with plugin_errors(entry, "fitting a gait"):
        fitted = organism.fit_gait(whole, frequency, rate, steered=False)
    if fitted is None:
        raise GaitsimError(
            f"a search cannot begin at a gait from a file with {entry}",
            where=str(file.path),
            allowed="a body with the method fit_gait(), such as a robot",
        )
    options = {f"organism.{name}": value for name, value in fitted.options.items()}
    found = with_overrides(experiment, options, "the fitted gait")
    own = Individual(found, math.nan, {}, 1, fitted.genome)
    own = replace(own, score=own.replayed_score, terms=own.replayed_terms)
    away = np.degrees(fitted.joint_angles - whole)
    given = play_gait(file, experiment)
    about = (
        f"{file.path}: {frequency:.3g} strides per second"
        + f", taken as one cycle and repeated {cycles} times" * (cycles > 1)
        + f"; fitted to within {math.sqrt(np.square(away).mean()):.1f}° (root mean square, at most "
        f"{np.abs(away).max():.1f}°). Played, the file scores {given.score:.4g}, the fitted gait "
        f"{own.score:.4g}"
    )
    changed = [
        f"{name}={brief(value)}"
        for name, value in fitted.options.items()
        if getattr(organism, name, None) != value
    ]
    if changed:
        about += f". The body has other options now: {', '.join(changed)}"
    return FoundStart(found, own, about)


def _frequency(angles: NDArray[np.float64], rate: float) -> float:
    """Return the strides per second, if at least two strides repeat; otherwise 0."""
    frequency = float(angles_frequency(angles[None], rate)[0])
    return frequency if frequency * len(angles) / rate >= 1.5 else 0.0
