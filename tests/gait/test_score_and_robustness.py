"""Terms over time and in words; the same gait under other conditions."""

import re
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gaitsim.contracts import Channel, Motion
from gaitsim.experiment import load_experiment, with_overrides
from gaitsim.gait.gait_files import GaitFile, play_gait
from gaitsim.gait.robustness import EXPLOIT, FRAGILE, measure_robustness, mirrored_joints
from gaitsim.gait.score_breakdown import (
    cut_motion,
    summarise,
    term_changes,
    terms_over_time,
    upper_bound,
)
from gaitsim.individual import Individual


@pytest.fixture
def on_the_spider(spider, reference):
    """A reference gait as a individual."""

    def make(name, experiment=spider):
        return play_gait(GaitFile(f"{name}.npz", reference(name), 30.0, ()), experiment)

    return make


def columns(**terms):
    """A history of the bests' terms; means are half of them."""
    first = next(iter(terms.values()))
    rows = {
        name: np.full(len(first), 1.0)
        for name in ("evaluations", "mean", "median", "worst", "std", "diversity", "seconds")
    }
    return {
        "generation": np.arange(1.0, len(first) + 1),
        **rows,
        "best": np.sum(list(terms.values()), axis=0),
        **{name: np.array(values) for name, values in terms.items()},
        **{f"mean:{name}": np.array(values) / 2 for name, values in terms.items()},
    }


def test_a_motion_is_cut_along_time_alone():
    timed, still = np.arange(24).reshape(2, 4, 3), np.arange(8).reshape(2, 4)
    channels = {"a": Channel(("frames", "joints"), "rad", ""), "b": Channel(("feet",), "", "")}
    part = cut_motion(Motion(5.0, {"a": timed, "b": still, "c": timed}), channels, 3)
    assert sorted(part) == ["a", "b"]
    assert part["a"].tolist() == timed[:, :3].tolist()
    assert part["b"] is still
    assert part.frame_rate == 5.0


def test_terms_over_time_end_with_the_score(on_the_spider):
    individual = on_the_spider("alternating-tetrapod")
    found = terms_over_time(individual)
    assert found.seconds[-1] == pytest.approx(299 / 30)
    assert np.diff(found.seconds) == pytest.approx(1.0)
    assert {name: values[-1] for name, values in found.terms.items()} == individual.terms
    # Forward is what it had walked by then, at its even speed.
    assert found.terms["forward"] == pytest.approx(0.125 * found.seconds, abs=0.01)
    assert found.timed
    # A search that reads measures does not need their channels of a part of the motion.
    atlas = replace(individual, experiment=load_experiment("spider-atlas"))
    assert terms_over_time(atlas).terms["forward"] == pytest.approx(found.terms["forward"])


def test_a_motion_that_fails_has_no_score(puppet, install):
    source = (
        "from gaitsim_puppets import Puppet\n"
        "class Falls(Puppet):\n    def move(self, genomes):\n"
        "        motion = super().move(genomes)\n        motion.failures[0] = 'it fell'\n"
        "        return motion\n"
    )
    install("falls", source, {"organism": {"falls": "Falls"}})
    experiment, genome = puppet("organism.plugin=falls"), np.full(3, 0.5)
    individual = Individual(experiment, 2.5, {"reach": 2.5}, 3, genome)
    assert individual.replayed_score == -np.inf
    assert individual.replayed_failure == "it fell"
    assert np.isfinite([*individual.replayed_terms.values()]).all()
    found = measure_robustness(individual, {})
    assert (found.perturbations, found.missing) == ((), ("the motion fails: it fell",))


def test_the_summary_of_one_term_is_empty():
    assert summarise({"travel": 3.0}, {}, None) == ()
    assert summarise({"a": 9.0, "b": 0.001}, {}, None) == (
        "a dominates: 100% of all gains and losses",
        "negligible: b",
    )


def test_terms_change_since_the_fitness_changed():
    history = columns(now=[np.nan, np.nan, 1, 4], then=[5.0, 6, np.nan, np.nan])
    first, (change,) = term_changes(history, 4)
    assert (first, change.name, change.gain, change.mean_last) == (3, "now", 3, 2)
    # In a stage of its own, a term of the same name is another one.
    history = columns(a=[9.0, 9, 1, 2, 4], b=[0.0, 0, 0, 0, 0]) | {
        "stage": np.array([0, 0, 1, 1, 1.0])
    }
    first, (change, _) = term_changes(history, 5)
    assert (first, change.first) == (3, 1)
    assert summarise({"a": 4.0, "b": 0.0}, history, 5)[-1] == "unchanged: b since generation 3"
    assert term_changes(history, 2)[0] == 1


def test_the_change_of_a_settled_term_is_below_the_stated_bound():
    settled = np.array([-2.0, -0.02, -0.031, -0.0201, -0.02, -0.02, -0.02])
    history = columns(a=[0.0, 1, 2, 3, 4, 5, 9], b=settled)
    said = summarise({"a": 9.0, "b": -0.02}, history, 7, "m")[-1]
    found = re.fullmatch(r".*: b by less than (\S+) m since generation 2", said)
    assert np.ptp(settled[1:]) < float(found[1]) <= 1.1 * np.ptp(settled[1:])


@given(st.floats(1e-12, 1e12))
def test_upper_bounds_have_two_digits(value):
    bound = upper_bound(value)
    assert value < bound <= 1.1 * value * (1 + 1e-9)
    assert float(f"{bound:.1e}") == bound


def test_joints_find_their_partners():
    assert mirrored_joints(("L1 coxa", "R1 coxa", "spine")) == [1, 0, 2]
    assert mirrored_joints(("left knee", "right knee")) == [1, 0]
    assert mirrored_joints(("L_hip", "R_hip")) == [1, 0]
    assert mirrored_joints(("Lumbar", "Rib")) is None  # words, not sides
    assert mirrored_joints(("L1 coxa", "L2 coxa")) is None
    assert mirrored_joints(()) is None


def test_a_walk_is_robust_and_a_flip_flop_collapses(on_the_spider):
    walk = measure_robustness(on_the_spider("alternating-tetrapod"), {})
    assert walk.worth == abs(walk.score)
    by_name = {trial.name: trial for trial in walk.perturbations}
    assert by_name["played again"].score == walk.score
    assert by_name["mirrored"].fall == pytest.approx(0, abs=1e-3)
    for name in ("all joints 3 frames late", "servos with a lag of 1 frame"):
        assert 0 < by_name[name].fall < 0.25
    assert not any(trial.sign == EXPLOIT for trial in walk.perturbations)
    # Its feet must all come down at once: on feet a millimetre or two apart, few stand.
    assert by_name["each joint off by about 1°"].sign == FRAGILE
    assert [text.partition(":")[0] for text in walk.missing] == [
        "half the time step",
        "inexact genes",
    ]
    flips = on_the_spider("flip-flop", load_experiment("spider-recurrence"))
    shaken = {trial.name: trial for trial in measure_robustness(flips, {}).perturbations}
    assert shaken["every second frame left out"].sign == EXPLOIT
    assert measure_robustness(flips, {}) == measure_robustness(flips, {})


def first_best(score):
    """A history of one generation."""
    return columns(forward=[0.0]) | {"best": np.array([score])}


def test_a_fall_is_compared_with_what_the_score_gained(on_the_spider):
    individual = on_the_spider("wave")
    found = measure_robustness(individual, first_best(individual.score - 10))
    assert found.worth == pytest.approx(10)
    assert measure_robustness(individual, first_best(individual.score + 1)).worth == abs(
        individual.score
    )
    assert measure_robustness(individual, first_best(-np.inf)).worth == abs(individual.score)


class _Stepped:
    """Plugins whose body simulates with a time step, which its score comes from."""

    source: ClassVar[str] = (
        "from gaitsim.contracts import Motion, option\nfrom gaitsim_puppets import Puppet\n"
        "class Stepped(Puppet):\n    dt: float = option(0.1, 'step', gt=0.04)\n"
        "    def move(self, genomes):\n        reach = genomes.sum(axis=1) * self.dt\n"
        "        return Motion(4.0, {'joint_angles': 0 * genomes[:, None], 'reach': reach})\n"
    )


def test_half_the_time_step_where_a_body_has_one(puppet, install):
    install("stepped", _Stepped.source, {"organism": {"stepped": "Stepped"}})
    genome = np.array([1.0, 1.0, 1.0])

    def robustness(step):
        experiment = puppet("organism.plugin=stepped", f"organism.dt={step}")
        motion = experiment.organism.move(genome[None])
        return measure_robustness(Individual(experiment, 0.0, {}, 1, genome, played=motion), {})

    found = robustness(0.1)
    trials = {trial.name: trial for trial in found.perturbations}
    half = trials["half the time step, 0.05 s"]
    assert (half.score, half.fall, half.sign) == (pytest.approx(0.15), pytest.approx(0.5), "")
    assert trials["genes inexact by 1% of their range"].sign == ""
    assert len(found.missing) == 2
    for missing, what in zip(found.missing, ("late, lagging and mirrored", "inexact"), strict=True):
        assert missing.startswith(f"{what} joints: organism 'stepped'")
        assert "cannot play given joint angles" in missing
    assert any("half the time step: the" in text for text in robustness(0.05).missing)


def test_a_genome_that_fails_with_one_flipped_gene_is_fragile(puppet, install):
    source = (
        "import numpy as np\nfrom gaitsim.contracts import Motion\nfrom gaitsim_puppets import "
        "BitPuppet\nclass Lock(BitPuppet):\n    def move(self, genomes):\n"
        "        reach = 1.0 * (genomes == 1).all(axis=1)\n"
        "        return Motion(4.0, {'joint_angles': 0.0 * genomes[:, None], 'reach': reach})\n"
    )
    install("lock", source, {"organism": {"lock": "Lock"}})
    experiment = with_overrides(puppet(), {"organism.plugin": "lock"})
    genome = np.ones(3, dtype=np.uint8)
    motion = experiment.organism.move(genome[None])
    individual = Individual(experiment, 1.0, {}, 1, genome, played=motion)
    (found,) = measure_robustness(individual, first_best(0.0)).perturbations
    assert (found.name, found.fall, found.sign) == ("one gene flipped", 1.0, FRAGILE)
    assert genome.tolist() == [1, 1, 1]
