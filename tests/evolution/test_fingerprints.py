"""No change of the code may change a bit of the results of a preset."""

import json
from pathlib import Path

import pytest

import gaitsim
from gaitsim.registry import EXPERIMENTS, entries

# Seed 0; recorded on x86-64 with AVX2. Another processor may round the last bit of a sine
# differently. Bodies that take long evolve fewer generations, and a small population.
FINGERPRINTS = json.loads(Path(__file__).with_name("fingerprints.json").read_text())
QUICK, LONG = FINGERPRINTS["15 generations"], FINGERPRINTS["2 generations"]
SMALL = FINGERPRINTS["3 generations of 8"]


def evolves_to(fingerprint, preset, folder, **options):
    with gaitsim.evolve(preset, seed=0, out=folder / "run", **options) as search:
        assert len([*search]) == options["generations"]
    assert search.run.fingerprint() == fingerprint


def test_every_preset_has_a_recorded_fingerprint():
    # The results of robots hold within one version of MuJoCo, which installs newest.
    presets = entries(EXPERIMENTS).items()
    names = {name for name, [preset] in presets if "robot" not in preset.target}
    assert QUICK.keys() | LONG.keys() == names
    assert LONG.keys() == SMALL.keys()


@pytest.mark.parametrize("preset", QUICK)
def test_a_preset_evolves_to_the_recorded_bits(preset, tmp_path):
    evolves_to(QUICK[preset], preset, tmp_path, generations=15)


@pytest.mark.slow
@pytest.mark.parametrize("preset", LONG)
def test_a_long_preset_evolves_to_the_recorded_bits(preset, tmp_path):
    evolves_to(LONG[preset], preset, tmp_path, generations=2)


@pytest.mark.parametrize(
    "preset",
    [
        name if name in ("fly", "walker") else pytest.param(name, marks=pytest.mark.slow)
        for name in SMALL
    ],
)
def test_a_small_population_evolves_to_the_recorded_bits(preset, tmp_path):
    evolves_to(SMALL[preset], preset, tmp_path, generations=3, population=8, workers=1)
