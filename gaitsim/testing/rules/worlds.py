"""Rules for a body that can be in several worlds."""

from collections.abc import Iterator

import numpy as np

from gaitsim.contracts import Genomes, Motion, Organism
from gaitsim.experiment import WORLD
from gaitsim.testing.report import Finding, error
from gaitsim.testing.rules.bits import other_shapes, same, same_space


def in_other_worlds(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    """Check the conditions of a body, its nominal world, and one that differs in all of them."""
    conditions = body.conditions()
    if not conditions:
        return
    if WORLD not in type(body).model_fields:
        yield error(
            "worlds",
            f"the option {WORLD!r} of a body with conditions",
            "none",
            f"declare {WORLD}: dict[str, float] = option({{}}, WORLD_HELP)",
        )
        return
    for name, one in conditions.items():
        usual = one.least <= one.low <= one.high <= one.most
        if not (usual and one.least <= one.nominal <= one.most):
            yield error(
                "worlds",
                f"{name}: low ≤ high, and both and the nominal value from least to most",
                f"{one!r}",
                "correct the condition",
            )
            return
    own = dict(body)[WORLD]
    nominal = {name: one.nominal for name, one in conditions.items()}
    told = type(body).model_validate({**dict(body), WORLD: {**nominal, **own}})
    if not same(told.move(genomes.copy()), motion):
        yield error(
            "worlds",
            "in a world with all nominal values, the motion of a body that is told none",
            "another",
            "let a condition with its nominal value change no bit",
        )
    far = {
        name: one.low if one.low != one.nominal else one.high for name, one in conditions.items()
    }
    other = type(body).model_validate({**dict(body), WORLD: {**far, "seed": 1.0}})
    if not same_space(body, other):
        yield error(
            "worlds",
            "the same genome space in every world",
            "another",
            f"let genome_space() not depend on {WORLD!r}",
        )
        return
    moved = other.move(genomes.copy())
    if shapes := other_shapes(motion, moved):
        yield error(
            "worlds",
            f"{shapes[0]}: the same shape in every world, {motion[shapes[0]].shape}",
            f"shape {np.shape(moved[shapes[0]])}",
            "keep the number of frames and joints",
        )
