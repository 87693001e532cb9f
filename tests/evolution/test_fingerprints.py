"""No change of the code may change a bit of what a preset evolves."""

import json
from pathlib import Path

import pytest

import gaitsim
from gaitsim.registry import EXPERIMENTS, entries

# Of 15 generations with seed 0, recorded on x86-64 with AVX2. Another processor may round the last
# bit of a sine differently.
FINGERPRINTS = json.loads(Path(__file__).with_name("fingerprints.json").read_text())


def test_every_preset_has_a_recorded_fingerprint():
    assert FINGERPRINTS.keys() == set(entries(EXPERIMENTS))


@pytest.mark.parametrize("preset", FINGERPRINTS)
def test_a_preset_evolves_to_the_recorded_bits(preset, tmp_path):
    with gaitsim.evolve(preset, generations=15, seed=0, out=tmp_path / "run") as search:
        assert len([*search]) == 15
    assert search.run.fingerprint() == FINGERPRINTS[preset]
