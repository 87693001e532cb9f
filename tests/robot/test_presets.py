"""The presets of the bundled robots find gaits that walk."""

import pytest

import gaitsim


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["quadruped", "hexapod", "spider-physics"])
def test_the_first_tenth_of_a_search_finds_a_walk_without_a_fall(preset):
    search = gaitsim.evolve(preset, generations=10)
    assert [*search]
    found = search.champion.measures
    assert found["lasted"] == 10.0
    assert found["body lengths"] > 5
    assert abs(found["yaw"]) < 30
