"""The gaits of many individuals at once."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.gait.repertoire import gaits_of, patterns
from gaitsim.gait.report import analyse_individual
from gaitsim.individual import Individual


@pytest.mark.parametrize("symmetry", ["none", "alternating"])
def test_names_are_those_of_the_analysis_of_each(symmetry):
    experiment = load_experiment("spider-genetic", {"organism.symmetry": symmetry})
    genomes = experiment.space().random(12, np.random.default_rng(5))
    genomes[3] = (experiment.space().lower + experiment.space().upper) / 2
    found = [gait for part in gaits_of(experiment, genomes) for gait in part]
    blank = Individual(experiment, 0.0, {}, generation=1)
    for genome, gait in zip(genomes, found, strict=True):
        analysis = analyse_individual(replace(blank, genome=genome))
        assert gait.name == replace(analysis.name, pattern=gait.name.pattern)
        feet = analysis.footfalls.feet
        assert gait.duty_factor == pytest.approx(np.mean([foot.duty_factor for foot in feet]))
        stride = analysis.footfalls.stride
        assert gait.frequency == (stride.frequency if stride else None)


def test_the_best_of_each_pattern_is_listed_and_gaits_without_a_name_come_last():
    experiment = load_experiment("spider-genetic")
    genomes = experiment.space().random(12, np.random.default_rng(5))
    gaits = [gait for part in gaits_of(experiment, genomes) for gait in part]
    scores = np.arange(12.0)
    found = patterns(gaits, scores)
    assert sum(one.count for one in found) == 12
    assert len({one.name for one in found}) == len(found)
    for one in found:
        assert gaits[one.member - 1].name.name == one.name
        assert one.score == scores[one.member - 1]
    assert "none" not in [one.name for one in found[:-1]]
    assert not patterns([], np.empty(0))


def test_a_body_without_feet_has_no_names():
    experiment = load_experiment("fly")
    with pytest.raises(GaitsimError, match="cannot be named"):
        next(gaits_of(experiment, experiment.space().random(2, np.random.default_rng(0))))
