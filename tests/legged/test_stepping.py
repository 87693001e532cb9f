"""Measures of steps, compared with the analysis of single gaits."""

from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

from gaitsim.experiment import load_experiment
from gaitsim.gait import analyse_individual, play_on_twin
from gaitsim.gait.feet import feet_of, phases_of
from gaitsim.gait.gait_files import play_gait, read_gait
from gaitsim.gait.naming import name_of
from gaitsim.legged import angles_frequency, stepping_measures
from gaitsim.legged.stepping import Steps, one_stance_per_stride

GAITS = Path(__file__).parents[2] / "data/gaits"
RATE = 30.0
SIDES = [("L1", "L2"), ("R1", "R2")]
LEGS = [name for side in SIDES for name in side]


@pytest.mark.packages
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


def chattering(random, period, duty, phases, frames=501):
    """Return the contacts of feet, most of whose stances and some of whose swings are interrupted.

    Interruptions last at most a tenth of a stride.
    """
    clean = (np.arange(frames)[:, None] / period - phases) % 1 < duty
    rough = clean.copy()
    for foot in range(len(phases)):
        edges = np.flatnonzero(np.diff(clean[:, foot])) + 1
        for start, end in pairwise(edges):
            if random.random() < (0.8 if clean[start, foot] else 0.3):
                length = random.integers(1, max(1, int(period / 10)) + 1)
                begin = random.integers(start + 1, max(start + 2, end - length))
                rough[begin : begin + length, foot] ^= True
    return rough


PHASES = {
    "trot": {"L1": 0, "L2": 0.5, "R1": 0.5, "R2": 0},
    "alternating tripod": {"L1": 0, "L2": 0.5, "L3": 0, "R1": 0.5, "R2": 0, "R3": 0.5},
    "lateral-sequence walk": {"L1": 0, "L2": 0.75, "R1": 0.5, "R2": 0.25},
}


def analysed(rough, names, period):
    """Return the estimated stride, and the feet, stride, phases and name at the commanded period.

    All are those of a body in physics with 50 frames per second.
    """
    estimated = feet_of(rough, names, 50.0, dynamic=True)[1]
    feet, stride = feet_of(rough, names, 50.0, dynamic=True, commanded=50 / period)
    phases = phases_of(feet, stride)
    places = np.array([[(-int(name[1]), 1.0 - 2 * (name[0] == "R"), 0) for name in names]])
    return estimated, feet, stride, phases, name_of(feet, stride, *phases, places, False)[0].name


@pytest.mark.parametrize("gait", PHASES)
@pytest.mark.parametrize("period", [20.0, 22.0166, 37.16, 61.3])
@pytest.mark.parametrize("duty", [0.4, 0.6, 0.75])
def test_chatter_does_not_change_what_a_gait_is(gait, period, duty):
    names, phases = zip(*PHASES[gait].items(), strict=True)
    rough = chattering(np.random.default_rng(1), period, duty, np.array(phases))
    estimated, feet, stride, (_, consistency), name = analysed(rough, names, period)
    assert estimated.frequency == pytest.approx(50 / period, rel=0.01)
    assert stride.frequency == 50 / period
    assert [foot.duty_factor for foot in feet] == pytest.approx([duty] * len(feet), abs=0.05)
    assert name == gait
    assert consistency.min() > 0.9
    found = stepping_measures(
        rough[None], names, 50.0, upright=np.array([501]), commanded=np.array([50 / period])
    )
    strides, downs = 501 / period, (~rough[:-1] & rough[1:]).sum(axis=0)
    assert found["stride frequency"].values[0] == 50 / period
    assert found["chatter"].values[0] == pytest.approx(downs.mean() / strides - 1, abs=0.05)
    assert found["chatter"].values[0] > 0.3


@pytest.mark.slow
def test_chatter_changes_few_of_many_random_gaits():
    """`docs/analysis.md` states these numbers."""
    wrong_names = frequencies = duties = count = 0
    for seed, (gait, feet) in product(range(40), PHASES.items()):
        names, phases = zip(*feet.items(), strict=True)
        for period in np.random.default_rng(seed).uniform(15, 70, 4):
            for duty in (0.35, 0.5, 0.65, 0.8):
                rough = chattering(np.random.default_rng(seed), period, duty, np.array(phases))
                estimated, found, _, _, name = analysed(rough, names, period)
                count += 1
                wrong_names += name != gait
                frequencies += abs(estimated.frequency * period / 50 - 1) > 0.01
                duties += max(abs(foot.duty_factor - duty) for foot in found) > 0.05
    assert (count, wrong_names, frequencies) == (1920, 0, 6)
    assert duties <= 0.011 * count


def test_the_stance_of_a_stride_is_the_interval_with_the_most_usual_contact():
    random = np.random.default_rng(2)
    stance = random.random((6, 90, 1)) < np.linspace(0.2, 0.9, 6)[:, None, None]
    found = one_stance_per_stride(stance, np.full(6, 15.0))
    for contacts, single in zip(stance[..., 0], found[..., 0], strict=True):
        usual = np.tile(contacts.reshape(6, 15).mean(axis=0), 6)
        worth = contacts + np.round(16 * usual) / 16 - 1
        turn = np.exp(2j * np.pi * np.arange(90) / 15)
        cut = np.angle(contacts @ turn) / (2 * np.pi) - 0.5
        stride = np.floor(np.arange(90) / 15 - cut)
        for number in np.unique(stride):
            part, chosen = worth[stride == number], single[stride == number]
            sums = [part[i:j].sum() for i in range(len(part)) for j in range(i + 1, len(part) + 1)]
            assert part[chosen].sum() == max(0, *sums)
            assert np.count_nonzero(np.diff(np.pad(chosen, 1))) in (0, 2)


@pytest.mark.packages
@pytest.mark.parametrize("encoding", ["steps", "sine", "cpg"])
def test_the_frequency_of_joint_angles_is_that_of_their_genome(encoding):
    organism = load_experiment("hexapod", {"organism.encoding": encoding}).organism
    genomes = organism.genome_space().random(40, np.random.default_rng(1))
    angles, frequency = organism._encoding.commands(genomes, 501)
    assert angles_frequency(angles, 50.0) == pytest.approx(frequency, rel=0.01)


def test_the_frequency_of_joint_angles_is_that_of_their_waves():
    time = np.arange(300) / 30.0
    two = np.sin(2 * np.pi * 1.37 * time[:, None] + [0, 1]) + 0.6 * np.cos(
        4 * np.pi * 1.37 * time[:, None] + [0.3, 2]
    )
    assert angles_frequency(two[None], 30.0)[0] == pytest.approx(1.37, rel=0.01)
    assert angles_frequency(np.zeros((1, 300, 2)), 30.0)[0] == 0
    assert angles_frequency(time[None, :, None], 30.0)[0] == 0


def test_a_command_without_steps_has_no_stride():
    still = np.ones((1, 200, 4), dtype=bool)
    found = Steps(still, 50.0, np.array([200]), np.array([1.5]))
    assert found.frequency[0] == found.period[0] == 0
    assert np.isnan(found.touches).all()
    trembling = still.copy()
    trembling[0, ::9] = False
    assert Steps(trembling, 50.0, np.array([200]), np.array([1.5])).frequency[0] == 0


def test_short_contacts_count_for_a_kinematic_body():
    twice = np.tile(np.repeat([True, False, True, False], [8, 4, 2, 6]), 10)[None, :, None]
    known = np.array([1.5])
    assert stepping_measures(twice, ["L1"], 30.0, commanded=known)["duty factor"].values[0] == 0.5
    upright = np.array([200])
    found = stepping_measures(twice, ["L1"], 30.0, upright=upright, commanded=known)
    assert found["duty factor"].values[0] == 0.4
    assert found["chatter"].values[0] == pytest.approx(1, abs=0.1)
