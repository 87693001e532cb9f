"""Evolve presets, and compare their fingerprints with the recorded ones.

python fingerprints.py [--set NAME] [PRESET …]
"""

import argparse
import json
import platform
import sys
import tempfile
from pathlib import Path

import gaitsim

RECORDED = json.loads(Path(__file__).with_name("fingerprints.json").read_text())
"""Fingerprints by set and preset, with the seed 0."""
OPTIONS = {
    "15 generations": {"generations": 15},
    # Bodies that take long evolve fewer generations, and a small population.
    "2 generations": {"generations": 2},
    "3 generations of 8": {"generations": 3, "population": 8},
}


def fingerprint(preset, options, folder):
    with gaitsim.evolve(preset, seed=0, out=folder / "run", **options) as search:
        assert len([*search]) == options["generations"]
    return search.run.fingerprint()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--set", choices=RECORDED, default="15 generations", dest="name")
    parser.add_argument("presets", nargs="*", metavar="PRESET", help="default: all of the set")
    chosen = parser.parse_args()
    recorded, different = RECORDED[chosen.name], 0
    for preset in chosen.presets or recorded:
        with tempfile.TemporaryDirectory() as folder:
            found = fingerprint(preset, OPTIONS[chosen.name] | {"workers": 1}, Path(folder))
        different += found != recorded[preset]
        verdict = "same" if found == recorded[preset] else f"different: {found}"
        print(platform.machine(), preset, verdict, flush=True)
    sys.exit(bool(different))


if __name__ == "__main__":
    main()
