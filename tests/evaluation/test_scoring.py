import numpy as np
import pytest

from gaitsim.contracts import Measure, Motion
from gaitsim.errors import PluginError
from gaitsim.evaluation import evaluate
from gaitsim.evaluation.scoring import Evaluation, join_evaluations

GENOMES = np.linspace(-1, 2, 12).reshape(4, 3)
ARCHIVE = ["search.plugin=map-elites", "search.axes.shoulder=[-1, 2]", "search.cells=[3]"]
INF, NAN = np.inf, np.nan


@pytest.fixture
def scored(puppet, puppets, monkeypatch):
    """Score four genomes with the given terms."""

    def scored(terms):
        monkeypatch.setattr(puppets.Reach, "terms", lambda self, motion: terms)
        return evaluate(puppet(), GENOMES)

    return scored


def test_the_score_is_the_sum_of_the_terms_in_their_order(scored):
    terms = {"a": [1e16, 1, 2, 3], "b": [1.0, 1, 2, 3], "c": [-1e16, 0, 0, 0]}
    evaluation = scored(terms)
    assert evaluation.scores.tolist() == [1e16 + 1.0 - 1e16, 2, 4, 6]
    assert list(evaluation.terms) == ["a", "b", "c"]
    assert evaluation.scores.dtype == np.float64
    assert evaluation.reasons == {}


def test_a_term_that_is_not_finite_fails_with_a_reason(scored):
    evaluation = scored(
        {"far": np.array([1, NAN, INF, 1e308]), "near": np.array([1, 2, -INF, 1e308])}
    )
    assert evaluation.scores.tolist() == [2, -INF, -INF, -INF]
    assert evaluation.reasons == {
        1: "far is nan",
        2: "far is inf, near is -inf",
        3: "the sum of the terms is too large",
    }
    assert np.isnan(evaluation.terms["far"][1])


def test_a_reason_with_a_lone_surrogate_is_escaped(puppet, puppets, monkeypatch):
    move = puppets.Puppet.move

    def failed(self, genomes):
        motion = move(self, genomes)
        motion.failures[1] = "no \udcff"
        return motion

    monkeypatch.setattr(puppets.Puppet, "move", failed)
    assert evaluate(puppet(), GENOMES).reasons == {1: r"no \udcff"}


def test_a_body_gets_a_writable_copy_of_the_genomes(puppet, puppets, monkeypatch):
    genomes, seen = GENOMES.copy(), []
    genomes.setflags(write=False)
    real = puppets.Puppet.move
    monkeypatch.setattr(
        puppets.Puppet, "move", lambda self, lent: (seen.append(lent.flags), real(self, lent))[1]
    )
    evaluate(puppet(), genomes)
    assert seen[0].writeable
    assert seen[0].c_contiguous
    assert np.array_equal(genomes, GENOMES)


def test_only_the_measures_that_the_search_reads_are_computed(puppet, puppets, monkeypatch):
    computed = []

    def measures(self, motion):
        def shoulder():
            computed.append("shoulder")
            return motion["joint_angles"][:, -1, 0]

        return {"shoulder": Measure(shoulder, "rad", ""), "elbow": Measure(fail, "rad", "")}

    monkeypatch.setattr(puppets.Puppet, "measures", measures)
    evaluation = evaluate(puppet(*ARCHIVE), GENOMES)
    np.testing.assert_array_equal(evaluation.values["shoulder"], GENOMES[:, 0])
    assert computed == ["shoulder"]


def moves_to(**channels):
    return lambda self, genomes: Motion(4.0, channels)


def lazily(function):
    return lambda self, genomes: Motion(
        4.0, {"joint_angles": genomes[:, None]}, {("reach",): function}
    )


def shift(self, genomes):
    genomes += 1
    return Motion(4.0, {"joint_angles": genomes[:, None], "reach": genomes[:, 0]})


def fail(*arguments):
    raise ZeroDivisionError("by nought")


BODIES = {
    "it raises": (fail, "moving a population: ZeroDivisionError: by nought"),
    "no motion": (lambda *arguments: None, "returned a NoneType as its motion"),
    "a missing channel": (moves_to(joint_angles=GENOMES[:, None]), "computing the channel 'reach'"),
    "a channel of none": (
        moves_to(joint_angles=GENOMES[:, None], reach=1.0),
        r"channel 'reach' with the shape \(\)",
    ),
    "a channel with an axis that is not declared": (
        moves_to(joint_angles=GENOMES[:, None], reach=GENOMES),
        r"channel 'reach' with the shape \(4, 3\)",
    ),
    "a channel that raises later": (lazily(fail), "the channel 'reach': ZeroDivisionError"),
    "changed genomes": (shift, "modifies the genomes passed to it"),
}


@pytest.mark.parametrize(("move", "says"), BODIES.values(), ids=BODIES.keys())
def test_a_body_that_breaks_its_contract_is_named(puppet, puppets, monkeypatch, move, says):
    monkeypatch.setattr(puppets.Puppet, "move", move)
    with pytest.raises(PluginError, match=says) as error:
        evaluate(puppet(), GENOMES)
    assert "organism 'puppet' of package gaitsim-puppets 1.0" in error.value.what
    assert error.value.remedy


def test_a_fitness_that_changes_the_motion_is_named(puppet, puppets, monkeypatch):
    def view(self, genomes):
        return Motion(4.0, {"joint_angles": genomes[:, None], "reach": genomes[:, 0].copy()})

    monkeypatch.setattr(puppets.Puppet, "move", view)

    def halve(self, motion):
        motion["joint_angles"][:] /= 2
        return {"reach": motion["reach"]}

    monkeypatch.setattr(puppets.Reach, "terms", halve)
    with pytest.raises(PluginError, match=r"fitness 'puppet-reach'.* modifies the motion"):
        evaluate(puppet(), GENOMES)


TERMS = {
    "nothing": (None, "returned None"),
    "no terms": ({}, r"returned \{\}"),
    "one number": ({"a": 1.0}, r"the term 'a' with the shape \(\)"),
    "a column": ({"a": np.zeros((4, 1))}, r"the shape \(4, 1\)"),
    "texts": ({"a": ["1", "2", "3", "4"]}, "for the term 'a'"),
    "ragged": ({"a": [[1], [1, 2], 3, 4]}, "for the term 'a'"),
    "a number as name": ({1: np.zeros(4)}, "names a term 1"),
    "a name of two lines": ({"a\nb": np.zeros(4)}, "names a term 'a.nb'"),
    "an endless name": ({"a" * 201: np.zeros(4)}, "names a term 'aaa"),
}


@pytest.mark.parametrize(("terms", "says"), TERMS.values(), ids=TERMS.keys())
def test_a_fitness_that_breaks_its_contract_is_named(scored, terms, says):
    with pytest.raises(PluginError, match=says) as error:
        scored(terms)
    assert "fitness 'puppet-reach' of package gaitsim-puppets 1.0" in error.value.what
    assert len(error.value.what) < 250
    assert error.value.allowed


def part(*scores, **terms):
    reasons = {index: f"why {s}" for index, s in enumerate(scores) if s == -INF}
    return Evaluation(np.array(scores), {n: np.array(v) for n, v in terms.items()}, reasons)


def test_parts_with_different_terms_are_refused(puppet):
    with pytest.raises(PluginError, match=r"'puppet-reach'.* b after a"):
        join_evaluations(puppet(), [part(1.0, a=[1.0]), part(1.0, b=[1.0])])
