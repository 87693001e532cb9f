"""No change of the code, and no other processor, may change a bit of the results of a preset."""

import os
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from fingerprints import OPTIONS, RECORDED, fingerprint

from gaitsim.experiment import PORTABLE, load_experiment
from gaitsim.registry import EXPERIMENTS, entries

QUICK, LONG, SMALL = RECORDED
ENGINE = {"pymunk": "7.3.1"}  # the version that the walkers' fingerprints hold for
PRESETS = sorted({preset for recorded in RECORDED.values() for preset in recorded})
NOT_PORTABLE = {name for name in PRESETS if name.startswith("walker")}

# Settings under which libraries or Numba run as on a processor without AVX2 and fused multiply-add.
_NO_AVX2 = "-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable"
_X86_64_V3 = "AVX2 FMA3 X86_V3 X86_V4 AVX512F AVX512CD AVX512_SKX AVX512_ICL AVX512_SPR"
OTHER_PROCESSORS = {
    "libraries": {
        "NPY_DISABLE_CPU_FEATURES": _X86_64_V3,
        "PYTHONWARNINGS": "ignore::ImportWarning",
        "OPENBLAS_CORETYPE": "Nehalem",
        "GLIBC_TUNABLES": f"glibc.cpu.hwcaps={_NO_AVX2}",
    },
    "numba": {"NUMBA_CPU_NAME": "nehalem", "NUMBA_CPU_FEATURES": ""},
}


def evolves_to_the_recorded_bits(preset, name, folder, **options):
    if preset in NOT_PORTABLE:
        cpuinfo = Path("/proc/cpuinfo")
        if not (cpuinfo.exists() and {"fma", "asimd"} & {*cpuinfo.read_text().split()}):
            pytest.skip("recorded with glibc on a processor with fused multiply-add")
        if any(version(engine) != recorded for engine, recorded in ENGINE.items()):
            pytest.skip("recorded with another version of the physics engine")
    found = fingerprint(preset, OPTIONS[name] | options, folder)
    assert found == RECORDED[name][preset]


def test_every_preset_has_a_recorded_fingerprint():
    # Results in MuJoCo, which installs its newest version, hold within one version.
    presets, engine = entries(EXPERIMENTS).items(), ("gaitsim_robot.", "gaitsim_creatures.")
    names = {name for name, [preset] in presets if not preset.target.startswith(engine)}
    assert RECORDED[QUICK].keys() | RECORDED[SMALL].keys() == names
    # Some walkers take long: a small population of them is enough.
    assert RECORDED[LONG].keys() < RECORDED[SMALL].keys()


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_without_a_physics_engine_is_portable(preset):
    portability = load_experiment(preset).portability
    assert portability.startswith(PORTABLE) == (preset not in NOT_PORTABLE)


@pytest.mark.parametrize("preset", RECORDED[QUICK])
def test_a_preset_evolves_to_the_recorded_bits(preset, tmp_path):
    evolves_to_the_recorded_bits(preset, QUICK, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["fly", "walker"])  # of the others, small populations are enough
def test_a_long_preset_evolves_to_the_recorded_bits(preset, tmp_path):
    evolves_to_the_recorded_bits(preset, LONG, tmp_path)


@pytest.mark.parametrize(
    "preset",
    [
        name if name in ("fly", "walker") else pytest.param(name, marks=pytest.mark.slow)
        for name in RECORDED[SMALL]
    ],
)
def test_a_small_population_evolves_to_the_recorded_bits(preset, tmp_path):
    evolves_to_the_recorded_bits(preset, SMALL, tmp_path, workers=1)


@pytest.mark.slow
@pytest.mark.parametrize("processor", OTHER_PROCESSORS)
@pytest.mark.parametrize("name", [QUICK, SMALL])
def test_portable_presets_have_the_same_bits_on_other_processors(processor, name):
    if sys.platform != "linux" or os.uname().machine != "x86_64":
        pytest.skip("the settings are those of libraries for x86-64 on Linux")
    presets = [*RECORDED[QUICK]] if name == QUICK else ["fly", "fly-steer-left"]
    script = Path(__file__).with_name("fingerprints.py")
    found = subprocess.run(
        [sys.executable, script, "--set", name, *presets],
        env=os.environ | OTHER_PROCESSORS[processor],
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    assert found.returncode == 0, found.stdout + found.stderr
    assert found.stdout.count(" same\n") == len(presets)
