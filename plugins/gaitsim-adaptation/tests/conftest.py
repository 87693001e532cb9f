"""A body that can be damaged, and an atlas of its gaits."""

import pytest
from tui_driver import config, drive, state_folder  # noqa: F401 (fixtures)

LIMPING = """
import numpy as np
from gaitsim.contracts import Measure, option
from gaitsim.legged import DAMAGE_HELP, parse_damage
from gaitsim_puppets import Puppet
LEGS = {"A": ("shoulder",), "B": ("elbow",), "C": ("wrist",)}
class Limping(Puppet):
    damage: tuple[str, ...] = option((), DAMAGE_HELP)
    def move(self, genomes):
        lost = [damage.part for damage in parse_damage(self.damage, LEGS)]
        return super().move(np.where([leg in lost for leg in LEGS], 0.0, genomes))
    def leg_joints(self):
        return LEGS
    def measures(self, motion):
        angles = motion["joint_angles"][:, -1]
        turned = {f"turn {leg}": Measure(angles[:, at], "rad", "") for at, leg in enumerate(LEGS)}
        return {"forward": Measure(motion["reach"], "m", "sum of sines of its angles"), **turned}
"""
ATLAS = """
name = "atlas"
seed = 1
[evolution]
population = 60
generations = 4
[organism]
plugin = "limping"
[fitness]
plugin = "puppet-reach"
[search]
plugin = "map-elites"
axes = { "turn A" = [-1.0, 2.0], "turn B" = [-1.0, 2.0], "turn C" = [-1.0, 2.0] }
cells = 60
"""


@pytest.fixture
def atlas(install, gaitsim, tmp_path, once):
    """The folder of an atlas of a body with three legs."""
    install("limping", LIMPING, {"organism": {"limping": "Limping"}})
    (tmp_path / "atlas.toml").write_text(ATLAS)
    return once(
        "atlas", tmp_path / "runs/atlas", lambda: gaitsim("run", "atlas.toml", "--workers", 1)
    )
