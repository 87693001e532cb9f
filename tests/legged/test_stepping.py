"""Measures of steps, compared with the analysis of single gaits."""

from pathlib import Path

import numpy as np
import pytest

from gaitsim.experiment import load_experiment
from gaitsim.gait import analyse_individual, play_on_twin
from gaitsim.gait.gait_files import play_gait, read_gait
from gaitsim.legged import stepping_measures

GAITS = Path(__file__).parents[2] / "data/gaits"
RATE = 30.0
SIDES = [("L1", "L2"), ("R1", "R2")]
LEGS = [name for side in SIDES for name in side]


@pytest.mark.parametrize("physics", [False, True], ids=["spider", "twin"])
@pytest.mark.parametrize("gait", ["alternating-tripod", "alternating-tetrapod", "wave", "standing"])
def test_stride_and_phase_lag_match_the_analysis(gait, physics):
    individual = play_gait(read_gait(GAITS / f"{gait}.npz"), load_experiment("spider"))
    individual = play_on_twin(individual) if physics else individual
    found = individual.measures
    steps = analyse_individual(individual).footfalls
    if gait == "standing":
        assert steps.stride is None
        assert found["stride frequency"] == 0
        assert np.isnan(found["phase lag"])
        return
    assert found["stride frequency"] == pytest.approx(steps.stride.frequency, rel=1e-3)
    phase = {foot.name: at for foot, at in zip(steps.feet, steps.phases, strict=True)}
    behind = [
        phase[f"{side}{row + 1}"] - phase[f"{side}{row}"] for side in "LR" for row in (1, 2, 3)
    ]
    mean = np.angle(np.nanmean(np.exp(2j * np.pi * np.array(behind)))) / (2 * np.pi)
    assert found["phase lag"] == pytest.approx(mean % 1, abs=0.02)


def walking(duty, lag, strides=10, length=20):
    """Return the contacts of four feet, each `lag` of a stride behind the foot in front of it."""
    time = (np.arange(strides * length)[:, None] + 0.5) / length
    return ((time - np.array([0.0, lag, 0.5, 0.5 + lag])) % 1 < duty)[None]


def values(stance, **options):
    found = stepping_measures(stance, LEGS, RATE, sides=SIDES, **options)
    return {name: measure.values for name, measure in found.items()}


@pytest.mark.parametrize("lag", [0.0, 0.25, 0.5, 0.75])
def test_measures_of_regular_steps_are_exact(lag):
    found = values(walking(0.6, lag))
    assert found["duty factor R2"] == pytest.approx(0.6)
    assert found["stride frequency"] == pytest.approx(1.5)
    assert found["phase lag"] == pytest.approx(lag)


def test_steps_count_until_the_fall_and_chatter_does_not_count():
    random = np.random.default_rng(0)
    noisy = walking(0.6, 0.25)
    noisy[0, random.integers(0, 200, 12), random.integers(0, 4, 12)] ^= True
    fallen = walking(0.6, 0.25)
    fallen[:, 120:] = False
    still = np.ones_like(fallen)
    together = np.concatenate([noisy, fallen, still])
    frames = np.array([200, 120, 200])
    found = values(together, upright=frames)
    assert found["stride frequency"] == pytest.approx([1.5, 1.5, 0], rel=0.03)
    assert found["phase lag"] == pytest.approx([0.25, 0.25, np.nan], abs=0.05, nan_ok=True)
    assert found["duty factor"][1:] == pytest.approx([0.6, 1.0])
    for one in range(3):
        alone = values(together[[one]], upright=frames[[one]])
        for name, value in alone.items():
            np.testing.assert_array_equal(value, found[name][[one]])
