"""Rules for a body with conditions, which can differ between worlds."""

from collections.abc import Iterator

import numpy as np

from gaitsim.contracts import Genomes, Motion, Organism
from gaitsim.experiment import WORLD
from gaitsim.testing.report import Finding, error
from gaitsim.testing.rules.bits import changed_shapes, same, same_space


def check_worlds(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    """Check the conditions of a body, its nominal world, and a world with other conditions."""
    conditions = body.conditions()
    if not conditions:
        return
    if WORLD not in type(body).model_fields:
        yield error(
            "worlds",
            f"an option {WORLD!r}, because the body has conditions",
            "none",
            f"declare {WORLD}: dict[str, float] = option({{}}, WORLD_HELP)",
        )
        return
    for name, one in conditions.items():
        usual = one.least <= one.low <= one.high <= one.most
        if not (usual and one.least <= one.nominal <= one.most):
            yield error(
                "worlds",
                f"{name}: low ≤ high, and low, high and nominal between least and most",
                f"{one!r}",
                "correct the condition",
            )
            return
    own = dict(body)[WORLD]
    nominal = {name: one.nominal for name, one in conditions.items()}
    nominal_body = type(body).model_validate({**dict(body), WORLD: {**nominal, **own}})
    if not same(nominal_body.move(genomes.copy()), motion):
        yield error(
            "worlds",
            "the same motion with all nominal values set as with none set",
            "a different motion",
            "make sure that nominal values do not change a single bit",
        )
    far = {
        name: one.low if one.low != one.nominal else one.high for name, one in conditions.items()
    }
    other = type(body).model_validate({**dict(body), WORLD: {**far, "seed": 1.0}})
    if not same_space(body, other):
        yield error(
            "worlds",
            "the same genome space in every world",
            "a different space",
            f"make genome_space() independent of {WORLD!r}",
        )
        return
    moved = other.move(genomes.copy())
    if shapes := changed_shapes(motion, moved):
        yield error(
            "worlds",
            f"{shapes[0]}: the same shape in every world, {motion[shapes[0]].shape}",
            f"shape {np.shape(moved[shapes[0]])}",
            "return the same number of frames and joints in every world",
        )
