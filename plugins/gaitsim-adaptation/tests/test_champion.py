"""The share of a champion beside the share of the map, shared measurements, and poor maps."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_adaptation import trials
from gaitsim_adaptation.prior import poverty, read_prior
from gaitsim_adaptation.report import make_report, summary, trials_table
from gaitsim_adaptation.settings import AdaptationSettings

LOST = ("adapt", "atlas", "--damage", "A lost", "--trials", 2)


@pytest.fixture
def rival(atlas, gaitsim, tmp_path):
    """The performance on the intact body of the champion of a run, whose body was damaged."""
    text = (tmp_path / "atlas.toml").read_text().split('plugin = "map-elites"')[0]
    text = text.replace('name = "atlas"', 'name = "rival"') + 'plugin = "cma-es"'
    text = text.replace('"limping"', '"limping"\ndamage = ["B lost"]')
    (tmp_path / "rival.toml").write_text(text)
    gaitsim("run", "rival.toml", "--workers", 1)
    return float(np.sin(gs.load("rival").champion.genome).sum())


def test_a_champion_is_compared_on_the_intact_body(rival, gaitsim, atlas):
    def last(*options):
        return json.loads(gaitsim(*LOST, *options, "--json").stdout.splitlines()[-1])

    assert "champion" not in last()
    found = last("--champion", "rival")
    assert found["champion"] == pytest.approx(rival)
    assert found["share_of_champion"] == pytest.approx(found["measured"] / rival)
    shares = f"{found['share']:.0%} of the best in the atlas, {found['measured'] / rival:.0%}"
    shown = gaitsim(*LOST, "--champion", "rival").stdout
    assert f"{found['measured']:.3f} m, {shares} of the champion's {rival:.3g} m" in shown
    adaptation = gs.adapt(gs.load(atlas), ["A lost"], champion="rival")
    assert adaptation.reference.performance == pytest.approx(rival)
    wrong = gaitsim(*LOST, "--champion", "nothing", code=2).stderr
    assert "--champion" in wrong
    assert "--from" not in wrong


def test_a_champion_with_another_body_is_refused(atlas, puppet_run):
    with pytest.raises(GaitsimError, match="another body"):
        gs.adapt(gs.load(atlas), ["A lost"], champion=str(puppet_run().path))


def test_a_report_on_an_atlas_that_began_from_a_champion_shows_its_share(rival, gaitsim, tmp_path):
    gaitsim("run", "atlas.toml", "--from", "rival", "--out", "begun", "--workers", 1)
    folder, run = tmp_path / "losses", RunSnapshot(tmp_path / "begun")
    made = make_report(run, folder, settings=AdaptationSettings(2))
    assert (made.reference.run, made.reference.performance) == ("", pytest.approx(rival))
    text = summary(made, "begun")
    assert f"| of {rival:.3g} m | kept |" in text
    best = made.cases[0].best.measured
    assert f"| A | {len(made.cases[0].trials)} | {best:.3g} | {best / rival:.0%} |" in text
    header, first, *_ = trials_table(made).splitlines()
    assert header.endswith("measured,kept,of champion")
    measured, _, of_champion = map(float, first.split(",")[-3:])
    assert of_champion == pytest.approx(measured / rival)
    file = folder / "report.json"
    stored = json.loads(file.read_text())
    stored["reference"]["performance"] = 0
    file.write_text(json.dumps(stored))
    with pytest.raises(GaitsimError, match="is damaged"):
        make_report(run, folder, settings=AdaptationSettings(2))


def test_gaits_measured_on_the_intact_twin_serve_all_damage(atlas, monkeypatch):
    # No puppet has a twin; here, the body itself is measured in its place.
    monkeypatch.setattr(trials, "twin_of", lambda experiment: experiment)
    run, measured = RunSnapshot(atlas), []
    prior = read_prior(run)

    def measure(individual):
        measured.append(individual.member.number)
        return 0.5 + individual.member.number / 1000

    with ThreadPoolExecutor(1) as pool:
        first = trials.measure_intact(run, prior, measure, pool)
        assert sorted(measured) == sorted(first)
        assert trials.measure_intact(run, prior, measure, pool) == first
        assert len(measured) == len(first) + 1  # one gait loads the engine
        heavier = replace(prior.experiment, name="another")
        trials.measure_intact(run, replace(prior, experiment=heavier), measure, pool)
    assert len(measured) == 2 * len(first) + 1


def test_an_atlas_that_is_too_poor_gets_a_warning(atlas, gaitsim):
    prior = read_prior(RunSnapshot(atlas))
    rich = replace(prior, performance=np.linspace(0, 1, 100))
    assert "too few or too slow" in poverty(prior)
    assert poverty(rich) == ""
    assert "best of which has forward 0.05 m" in poverty(
        replace(rich, performance=np.full(100, 0.05))
    )
    assert poverty(replace(rich, performance=np.full(100, 0.05), unit="")) == ""
    assert "gaitsim resume runs/atlas --generations" in gaitsim(*LOST).stderr
