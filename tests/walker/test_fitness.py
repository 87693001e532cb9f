"""The fitness `distance`: its terms, and walkers that evolve with it."""

import numpy as np
import pytest

from gaitsim.contracts import Motion
from gaitsim.evaluation import Evaluator
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment
from gaitsim_walker.distance import Distance

FRAMES = 61  # 1 s


def motion(**changed):
    """Return the motion of a walker that stands still on two feet, with some channels replaced."""
    channels = {
        "joint_angles": np.zeros((1, FRAMES, 4)),
        "joint_positions": np.zeros((1, FRAMES, 4)),
        "torque": np.full((1, FRAMES, 4), 2.0),
        "torso": np.zeros((1, FRAMES, 3)),
        "pitch": np.zeros((1, FRAMES)),
        "height": np.full((1, FRAMES), 0.5),
        "slip": np.zeros((1, FRAMES)),
        "load": np.full((1, FRAMES, 2, 2), 40.0),
        "energy": np.zeros((1, FRAMES)),
        "lasted": np.array([1.0]),
    }
    return Motion(60.0, channels | {name: values[None] for name, values in changed.items()})


def along(start, end):
    return np.linspace(start, end, FRAMES)


def path(x):
    return np.stack([x, np.zeros(FRAMES), np.full(FRAMES, 0.5)], axis=-1)


def test_standing_still_scores_0_in_every_term():
    for name, values in Distance().terms(motion()).items():
        assert values == pytest.approx(0), name


LEAPS = np.zeros((FRAMES, 2, 2))
LEAPS[::2] = 40.0  # every second frame: a mean of about half, a root mean square of about 1/√2
OFF = np.full((FRAMES, 4), 0.1)


@pytest.mark.parametrize(
    ("term", "changed", "expected"),
    [
        ("forward", {"torso": path(along(1, 3))}, 2.0),
        ("fall", {"lasted": np.array(0.25)}, -7.5),
        ("energy", {"energy": along(0, 200)}, -1.0),
        ("jerk", {"torque": np.repeat(along(0, 10)[:, None], 4, axis=1)}, -0.05),
        ("lag", {"joint_angles": OFF}, -0.4),
        ("impact", {"load": LEAPS}, -5 * (np.sqrt(61 / 31) - 1)),
        ("pitch", {"pitch": np.full(FRAMES, -0.2)}, -1.0),
        ("slip", {"slip": np.full(FRAMES, 0.01)}, -0.61),
        ("bounce", {"height": 0.5 + 0.02 * np.cos(np.arange(FRAMES) * np.pi)}, -0.4),
        ("low", {"height": np.append(0.5, np.full(FRAMES - 1, 0.325))}, -4 * np.sqrt(60 / 61)),
    ],
)
def test_each_penalty_follows_its_definition(term, changed, expected):
    terms = Distance().terms(motion(**changed))
    assert float(terms[term][0]) == pytest.approx(expected, rel=1e-2)
    others = {name for name, values in terms.items() if abs(values[0]) > 1e-9} - {term}
    assert others <= {"bounce"}


def test_movement_after_a_fall_is_not_a_leap():
    load = np.full((FRAMES, 2, 2), 40.0)
    load[31:] = 0.0
    terms = Distance().terms(motion(load=load, lasted=np.array(0.5)))
    assert terms["impact"] == pytest.approx(0)


def test_without_weights_the_score_is_the_distance():
    weights = {name: 0.0 for name in Distance.model_fields if name.endswith("weight")}
    terms = Distance(**weights).terms(motion(torso=path(along(0, 2)), lasted=np.array(0.1)))
    assert sum(float(values[0]) for values in terms.values()) == pytest.approx(2.0)


@pytest.mark.slow
def test_two_legs_walk_within_a_few_generations():
    experiment = load_experiment("walker", {"seed": 3, "evolution.generations": 4})
    with Evaluator(experiment, 1) as evaluator:
        for generation in evolve(experiment, evaluator.evaluate):
            last = generation
    walker = experiment.organism
    motion = walker.move(last.genomes[last.best][None])
    measures = {name: float(m.values[0]) for name, m in walker.measures(motion).items()}
    assert measures["lasted"] == 10
    assert measures["body lengths"] >= 3
    assert measures["slip ratio"] < 0.2
    duty = motion["stance"][0].mean(axis=0)
    assert (duty > 0.25).all()  # both legs carry it
