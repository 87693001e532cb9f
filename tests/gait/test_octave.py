"""GNU Octave, and therefore MATLAB, reads an exported gait."""

import shutil
import subprocess

import numpy as np
import pytest

from gaitsim.gait.gait_files import gait_of, write_gait

OCTAVE = shutil.which("octave-cli")
pytestmark = pytest.mark.skipif(OCTAVE is None, reason="GNU Octave is not installed")

SCRIPT = """
load('gait.mat');
[frames, joints] = size(bestGait);
printf('%d %d %g %d %.17g\\n', frames, joints, frameRate, generation, score);
printf('%s|', class(bestGait), units, class(jointNames), jointNames{1}, jointNames{end});
printf('\\n');
printf('%.17g\\n', bestGait);
"""


def test_octave_reads_the_gait_to_the_last_bit(spider_run, tmp_path):
    gait = gait_of(spider_run.individual())
    write_gait(gait, tmp_path / "gait.mat", "mat")
    done = subprocess.run(
        [OCTAVE, "--norc", "--no-history", "--quiet", "--eval", SCRIPT],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    sizes, texts, *values = done.stdout.splitlines()
    frames, joints, rate, generation, score = sizes.split()
    assert (int(frames), int(joints), float(rate)) == (300, 24, 30.0)
    assert (int(generation), float(score)) == (gait.generation, gait.score)
    assert texts.split("|")[:-1] == ["double", "rad", "cell", "L1 coxa", "R4 tibia"]
    # Column by column, as MATLAB has its arrays.
    read = np.array(values, dtype=np.float64).reshape(24, 300).T
    assert np.array_equal(read, gait.angles)
