"""A quantity has one value everywhere: in the replay, `show`, `analyse` and plots."""

import json
import math

import numpy as np
import pytest

from gaitsim.experiment import load_experiment
from gaitsim.gait import analyse_gait, analyse_individual
from gaitsim.gait.report import _SI, quantities, trial_skeletons
from gaitsim.gait.to_dict import gait_to_dict
from gaitsim.individual import Individual
from gaitsim.render.plots.style import LIGHT
from gaitsim_plots.feet import stability_figure

BODIES = ["spider", "walker", "millipede", "fly"]
PLACES = {"slip ratio": ("slip", "ratio"), "least margin": ("stability", "least")}
"""Places in the JSON output of quantities that are not in its `travel`."""


@pytest.mark.parametrize("preset", BODIES)
def test_a_word_has_one_value(bundled, gaitsim, preset):
    run = bundled(preset)
    individual = run.individual()
    measured = individual.measurements
    gait = analyse_individual(individual)
    table, found = quantities(gait), gait_to_dict(gait)
    both = measured.keys() & table.keys()
    assert both == {
        "spider": {"forward", "lateral", "yaw", "slip ratio", "least margin"},
        "walker": {"forward", "slip ratio", "cost of transport", "lasted"},
        "millipede": {"forward"},
        "fly": set(),
    }[preset]  # fmt: skip
    for name in both:
        own, other = measured[name], table[name]
        assert own.unit == other.unit
        assert own.value == pytest.approx(other.value, rel=1e-6) or (
            not math.isfinite(own.value) and math.isnan(other.value)
        )
    flat = {**found["travel"], **found, **(found["slip"] or {})}
    for name, own in measured.items():
        part, key = PLACES.get(name, ("travel", name.replace(" ", "_")))
        value = found[part][key] if name in PLACES else flat.get(key)
        if value is not None and math.isfinite(own.value):
            assert value == pytest.approx(own.value * _SI[own.unit], rel=1e-6), name
    shown = json.loads(gaitsim("show", run.path, "--json").stdout)["champion"]
    for name, own in measured.items():
        assert shown["units"][name] == own.unit
        if math.isfinite(own.value):
            assert shown["measures"][name] == own.value
    if "least margin" in measured:
        texts = stability_figure(individual, LIGHT).legends[0].texts
        least = f"least: {measured['least margin'].value:.1f} mm".replace("-", "−")
        assert least in [text.get_text() for text in texts]


@pytest.mark.parametrize("preset", BODIES)
def test_measures_of_a_body_agree_with_the_analysis(bundled, preset):
    """The measures that replace quantities of the skeleton agree with them approximately."""
    individual = bundled(preset).individual()
    seen = [analyse_gait(skeleton).travel for skeleton in trial_skeletons(individual)]
    known = analyse_individual(individual).travel
    for name in ("forward", "lateral", "climb", "yaw"):
        mean = np.mean([getattr(one, name) for one in seen])
        assert getattr(known, name) == pytest.approx(mean, rel=1e-3, abs=1e-3)


def test_the_travel_of_a_body_with_trials_is_the_mean_over_them():
    fly = load_experiment("fly-hover", {"organism.duration": 0.5})
    (wing_beat,) = fly.starts().values()
    individual = Individual(fly, 0.0, {}, 1, wing_beat)
    found = analyse_individual(individual)
    position = individual.motion["position"][0].astype(float)  # (frames, trials, 3)
    moved = position[-1] - position[0]
    assert found.trials == position.shape[1] > 1
    assert np.ptp(moved[:, 2]) > 1e-3
    mean = moved.mean(axis=0)
    travel = found.travel
    assert [travel.forward, travel.lateral, travel.climb] == pytest.approx(mean.tolist(), abs=1e-6)
    assert travel.speed == pytest.approx(np.hypot(*moved[:, :2].T).mean() / travel.seconds)
    assert gait_to_dict(found)["trials"] == found.trials
