"""Whether gaits hold in the worlds that their bodies name."""

import numpy as np
import pytest

from gaitsim.errors import PluginError
from gaitsim.experiment import load_experiment
from gaitsim.gait import check_gait, with_world
from gaitsim.gait.checks import Check, CheckResults
from gaitsim.gait.unseen import Outcome
from gaitsim.individual import Individual
from gaitsim.render.terminal.explanation import check_results

SHORT = load_experiment("quadruped", {"organism.duration": 1.0})
TROT = SHORT.starts()["trot"]


def results(nominal: Outcome, *outcomes: Outcome) -> CheckResults:
    checks = tuple(
        Check({"friction": 0.4 + number}, one, one.result / nominal.result, f"friction {number}")
        for number, one in enumerate(outcomes)
    )
    return CheckResults("forward", "m", nominal, checks)


def walked(distance: float, fell: bool = False) -> Outcome:
    return Outcome(distance, 0.0, fell)


def test_each_check_is_the_gait_in_that_world():
    individual = Individual(SHORT, 0.0, {}, 1, TROT)
    done = []
    found = check_gait(individual, workers=1, advance=done.append)
    assert sum(done) == len(found.checks) == 6
    for check in found.checks:
        alone = with_world(individual, check.world)
        assert check.outcome.result == alone.measures["forward"]
        assert check.kept == check.outcome.result / individual.measures["forward"]
        assert check.outcome.fell == (alone.measures["lasted"] < 1)


def test_a_gait_holds_if_it_keeps_three_quarters_and_never_falls():
    whole = walked(4.0)
    assert results(whole, walked(3.1), walked(4.5)).holds
    assert not results(whole, walked(2.9), walked(4.0)).holds
    assert not results(whole, walked(3.9, fell=True), walked(4.0)).holds
    assert not results(walked(4.0, fell=True), walked(4.0)).holds


def test_the_worst_check_is_one_with_a_fall():
    found = results(walked(4.0), walked(2.0), walked(3.0, fell=True), walked(3.9))
    assert found.worst.outcome.fell
    assert len(found.failed) == 2
    assert "75 %" in found.summary
    passage = check_results(found)
    assert passage.warning == found.summary
    assert [row[3] for row in passage.rows] == ["", "falls", ""]
    assert found.depends_on == ("friction 0", "friction 1")


@pytest.mark.parametrize("distance", [0.0, -1.0])
def test_a_gait_that_goes_nowhere_does_not_hold(distance):
    found = CheckResults(
        "forward", "m", walked(distance), (Check({"friction": 0.4}, walked(1.0), np.nan),)
    )
    assert not found.holds
    assert "nan" not in found.summary


@pytest.mark.parametrize(
    ("checks", "message"),
    [
        ([{"frction": 1.0}], "names an invalid check: unknown condition 'frction'"),
        ([{"friction": 9.0}], "names an invalid check: invalid value of the condition 'friction'"),
        ([{"friction": "much"}], "failed while naming its checks"),
        (None, "failed while naming its checks"),
    ],
)
def test_a_wrong_check_is_an_error_of_the_plugin(checks, message, monkeypatch):
    monkeypatch.setattr(type(SHORT.organism), "checks", lambda body: checks)
    with pytest.raises(PluginError, match=f"organism 'robot' of package gaitsim .* {message}"):
        check_gait(Individual(SHORT, 0.0, {}, 1, TROT))


def test_other_bodies_have_no_checks():
    walker = load_experiment("walker", {"organism.duration": 1})
    genome = walker.space().random(1, np.random.default_rng(0))[0]
    assert check_gait(Individual(walker, 0.0, {}, 1, genome)) is None
