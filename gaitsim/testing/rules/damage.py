"""Rules for a body that can be damaged."""

from collections.abc import Iterator

import numpy as np

from gaitsim.contracts import Genomes, Motion, Organism
from gaitsim.testing.report import Finding, error
from gaitsim.testing.rules.bits import changed_shapes, same_space
from gaitsim.testing.rules.views import check_skeleton


def check_damage(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    """Check that a body without its first leg accepts the genomes of the intact body."""
    legs = body.leg_joints()
    if "damage" not in type(body).model_fields or len(legs) < 2 or dict(body).get("damage"):
        return
    lost = f"{next(iter(legs))} lost"
    damaged = type(body).model_validate({**dict(body), "damage": (lost,)})
    if not same_space(body, damaged):
        yield error(
            "damage",
            f"the same genome space with '{lost}' as for the intact body",
            "a different space",
            "make genome_space() independent of 'damage'",
        )
        return
    moved = damaged.move(genomes.copy())
    if other := changed_shapes(motion, moved):
        yield error(
            "damage",
            f"{other[0]}: the same shape with '{lost}' as intact, {motion[other[0]].shape}",
            f"shape {np.shape(moved[other[0]])}",
            "keep the joints and the foot of a lost leg in the channels",
        )
        return
    yield from check_skeleton(damaged, moved)
