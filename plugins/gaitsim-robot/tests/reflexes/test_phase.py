"""The reflex `phase` is the oscillator of Owaki et al. 2013, whose period has a closed form."""

import numpy as np
import pytest
from bench import observation, step

from gaitsim_reflexes.phase import Phase


def rate(reflex, phase, load, duty=0.5):
    """Return the factor of the phase's speed, for one phase of all legs."""
    seen = observation(
        len(phase), phase=np.tile(phase, (4, 1)).T, load=np.full((len(phase), 4), load)
    )
    seen.duty[:] = duty
    return step(reflex, seen).rate[:, 0]


@pytest.mark.parametrize("duty", [0.5, 0.75])
@pytest.mark.parametrize(("gain", "load"), [(0.5, 0.25), (2.0, 0.4)])
def test_the_period_under_constant_load(duty, gain, load):
    """The integral of dφ / (1 − a cos φ) over a turn is 2π / √(1 − a²)."""
    phase = (np.arange(20_000) + 0.5) / 20_000
    period = (1 / rate(Phase(gain=gain, limit=1.0), phase, load, duty)).mean()
    assert period == pytest.approx(1 / np.sqrt(1 - (gain * load) ** 2), rel=1e-6)


def test_load_holds_a_leg_in_the_second_half_of_stance():
    phase = np.array([0.0, 0.125, 0.25, 0.375, 0.49999999])  # stance until 0.5
    factors = rate(Phase(gain=1.0, limit=1.0), phase, 0.5)
    assert factors == pytest.approx([1.5, 1 + 0.5 * np.sqrt(0.5), 1, 1 - 0.5 * np.sqrt(0.5), 0.5])
    assert (rate(Phase(), phase, 0.0) == 1).all()
    # A leg with a heavy load waits where 1 = σ N cos φ.
    stops = 0.25 + 0.5 * np.arcsin(1 / 2) / np.pi
    assert rate(Phase(gain=4.0, limit=1.0), np.array([stops]), 0.5)[0] == pytest.approx(0)


@pytest.mark.parametrize("ahead", [0.02, 0.8])
def test_two_legs_that_share_the_weight_end_up_in_antiphase(ahead):
    """The leg that is lower in its stance carries more."""
    reflex, phase, apart = Phase(gain=0.3), np.array([0.0, ahead]), []
    for _ in range(3000):
        turn = np.where(phase < 0.5, 1 + 2 * phase, 2 * phase - 1)
        depth = np.maximum(-np.sin(np.pi * turn), 0.0)
        load = depth / max(depth.sum(), 1e-9)
        seen = observation(phase=[[*phase, 0, 0]], load=[[*load, 0, 0]])
        phase = (phase + 0.01 * step(reflex, seen).rate[0, :2]) % 1
        apart.append((phase[1] - phase[0]) % 1)
    assert 0.44 < min(apart[-1000:]) < max(apart[-1000:]) < 0.56
