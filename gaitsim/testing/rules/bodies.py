"""Rules for a body: its genome space and its motion."""

import math
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from gaitsim.contracts import BitSpace, Channel, Genomes, GenomeSpace, Motion, Organism, RealSpace
from gaitsim.contracts.conditions import check_world
from gaitsim.errors import GaitsimError, PluginError
from gaitsim.evaluation.scoring import check_motion
from gaitsim.experiment import WORLD
from gaitsim.experiment.model import space_of, starts_of
from gaitsim.registry import Entry
from gaitsim.testing.report import Finding, advice, any_error, error
from gaitsim.testing.rules.common import (
    changed_shapes,
    first_difference,
    same,
    same_space,
    select_rows,
)
from gaitsim.testing.rules.steering import check_steering
from gaitsim.testing.rules.views import check_measures, check_play, check_rig, check_skeleton


def check_determinism(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    """Check that motions do not depend on repetition, order or chunks.

    Also check that `move` does not change the genomes.
    """
    whole = select_rows(motion, range(len(genomes)))
    argument = genomes.copy()
    # select_rows reads all channels, and so computes the derived channels.
    again = select_rows(body.move(argument), range(len(genomes)))
    if not same(argument, genomes):
        yield error(
            "inputs", "unchanged genomes", "move() changes them", "work on a copy: genomes.copy()"
        )
    name = first_difference(whole, again)
    if name:
        yield error(
            "determinism",
            "the same motion for the same genomes, bit for bit",
            f"{name} differs when the same genomes move a second time",
            "draw random numbers only from a seed that is an option, and keep no state",
        )
        return  # the next rules would fail for the same reason
    order = list(reversed(range(len(genomes))))
    orders = {"in reverse order": order, "alone": [2], "in a chunk of two": [4, 1]}
    for how, indices in orders.items():
        part = body.move(genomes[indices])
        name = first_difference(
            select_rows(motion, indices), select_rows(part, range(len(indices)))
        )
        if name:
            yield error(
                "chunks",
                "each individual's motion depends only on its own genome, bit for bit",
                f"{name} differs when individuals move {how}",
                "use no values of the whole population, such as its mean; a matrix product may "
                "round differently for a different number of rows",
            )
            return
    if body.threads:
        yield from _check_threads(body, genomes, motion)


def _check_threads(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    all_individuals = range(len(genomes))
    with ThreadPoolExecutor(2) as pool:
        parts = pool.map(
            lambda _: select_rows(body.move(genomes.copy()), all_individuals), range(6)
        )
    whole = select_rows(motion, all_individuals)
    name = next(filter(None, (first_difference(whole, part) for part in parts)), "")
    if name:
        yield error(
            "threads",
            "the same bits when two threads move populations concurrently, as 'threads' declares",
            f"{name} differs",
            "keep no state between calls, or remove 'threads = True'",
        )


def check_worlds(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    """Check the conditions of a body, its nominal world, and a world with other conditions."""
    conditions = body.conditions()
    for world in body.checks():
        try:
            check_world(world, conditions)
        except GaitsimError as problem:
            yield error(
                "worlds", "checks() names worlds of the body", problem.what, "correct the check"
            )
            return
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


COUNT = 6  # number of individuals moved
FEW, MANY = 3, 100  # sizes of the timed batches; MANY is a usual population
LONG = 0.2  # a small batch must take this long to estimate the time of a population from it, s
SLOW = 0.5  # time per further individual, s; 300 generations of 100 individuals take 4 hours

_REAL = "biuf"  # kinds of dtype that are real numbers


def body_rules(entry: Entry, body: Organism, figures: dict[str, float]) -> Iterator[Finding]:
    """Check all rules for a body with its current options.

    Stop after a violation of a rule that later rules depend on.
    """
    space = space_of(entry, body)
    if (yield from any_error(_check_space(body, space))):
        return
    yield from _check_starts(entry, body, space)
    genomes = sample_genomes(space)
    motion, seconds = _timed_move(body, genomes)
    figures["first_call_seconds"] = seconds
    if (yield from any_error(_check_motion(body, motion))):
        return
    assert isinstance(motion, Motion)
    yield from _check_values(body, motion)
    yield from check_determinism(body, genomes, motion)
    if not (yield from any_error(check_skeleton(body, motion))):
        yield from check_rig(body, motion)
    yield from check_measures(body, motion)
    yield from check_play(body, motion)
    yield from check_steering(body)
    yield from check_damage(body, genomes, motion)
    yield from check_worlds(body, genomes, motion)
    yield from _check_speed(body, space, figures)


def sample_genomes(space: GenomeSpace, count: int = COUNT) -> Genomes:
    """Return `count` random genomes, (count, genes).

    In a real space, the last two of more than two genomes lie at the lower and upper bounds.
    """
    genomes = space.random(count, np.random.default_rng(1))
    if isinstance(space, RealSpace) and count > 2:
        genomes[-2:] = space.repair(np.stack([space.lower, space.upper]))
    return genomes


def _check_space(body: Organism, space: GenomeSpace) -> Iterator[Finding]:
    if not isinstance(space, RealSpace | BitSpace):
        yield advice(
            "genome space",
            "a RealSpace or a BitSpace, which the installed operators support",
            f"a {type(space).__name__}",
            "provide a crossover and a mutation with this class in their 'spaces'",
        )
    if space.genes < 1 or len(set(space.labels)) < space.genes:
        yield error(
            "genome space",
            "at least one gene, and a unique label for each",
            f"{space.genes} genes, {len(set(space.labels))} labels",
            "return a different name for each gene in GenomeSpace.labels",
        )
        return
    genomes = space.random(50, np.random.default_rng(2))
    if not (len(genomes) == 50 and space.contains(genomes)):
        yield error(
            "genome space",
            "random genomes that belong to the space",
            f"shape {np.shape(genomes)}, dtype {genomes.dtype}, or genes outside the space",
            "call repair() at the end of random()",
        )
        return
    if not same(space.repair(genomes), genomes):
        yield error(
            "genome space",
            "repair() does not change valid genomes",
            "repair() changes them",
            "make 'repair_bits' return repaired genomes unchanged",
        )
    spaces = space, space, body.genome_space()
    first, *others = (one.random(5, np.random.default_rng(3)) for one in spaces)
    if not all(same(first, other) for other in others):
        yield error(
            "genome space",
            "the same genomes from the same generator, for each call of genome_space()",
            "different genomes",
            "draw only from the generator 'rng'",
        )


def _check_starts(entry: Entry, body: Organism, space: GenomeSpace) -> Iterator[Finding]:
    try:
        starts_of(entry, body, space)
    except PluginError as problem:
        yield error("starts", "valid genomes by printable names", problem.what, "")


def _timed_move(body: Organism, genomes: Genomes) -> tuple[object, float]:
    start = time.perf_counter()
    motion: object = body.move(genomes.copy())
    return motion, time.perf_counter() - start


def _check_motion(body: Organism, motion: object) -> Iterator[Finding]:
    """Check whether the result is a motion with valid channels, which later rules assume."""
    if not isinstance(motion, Motion):
        yield error(
            "motion",
            "move() returns a gaitsim.contracts.Motion",
            f"a {type(motion).__name__}",
            "return Motion(frame_rate, {'name of a channel': array, …})",
        )
        return
    if not (isinstance(motion.frame_rate, int | float) and 0 < motion.frame_rate < math.inf):
        yield error(
            "motion",
            "a frame rate above 0, in Hz",
            repr(motion.frame_rate),
            "Motion(frames / seconds, …)",
        )
    missing = [name for name in body.channels if name not in motion]
    if missing:
        yield error(
            "channels",
            "a motion with every channel of 'channels'",
            f"{', '.join(missing)} missing",
            "add them to the Motion, or remove them from 'channels'",
        )
    for name in motion:
        yield from _check_channel(name, motion[name], body.channels.get(name))


def _check_channel(name: str, array: object, channel: Channel | None) -> Iterator[Finding]:
    if not isinstance(array, np.ndarray) or array.dtype.kind not in _REAL:
        actual = f"a {type(array).__name__}"
        if isinstance(array, np.ndarray):
            actual = f"dtype {array.dtype}"
        yield error(
            "channels", f"{name}: an array of real numbers or bool", actual, "use np.asarray(…)"
        )
    elif array.shape[:1] != (COUNT,):
        yield error(
            "shapes",
            f"{name}: first axis (population,) = ({COUNT},)",
            f"shape {array.shape}",
            "use the first axis for the population, and the second for time",
        )
    elif channel is not None and not channel.fits(array.shape):
        yield error(
            "shapes",
            f"{name}: the declared axes {channel.shape}, with a population of {COUNT}",
            f"shape {array.shape}",
            "correct the axes in 'channels', or the array",
        )


def _check_axis_lengths(body: Organism, motion: Motion) -> Iterator[Finding]:
    """Check that axes of the same name are equally long, with one joint per `joint_names()`."""
    found = {"joints": ("joint_names()", len(body.joint_names()))}
    for name, channel in body.channels.items():
        for axis, length in zip(channel.axes, motion[name].shape[1:], strict=True):
            if not isinstance(axis, str):
                continue
            first, expected = found.setdefault(axis, (name, length))
            if length != expected:
                yield error(
                    "shapes",
                    f"{name}: {expected} {axis}, as in {first}",
                    f"{length}",
                    "use the same name only for axes of the same length",
                )


def _check_values(body: Organism, motion: Motion) -> Iterator[Finding]:
    undeclared = [name for name in motion if name not in body.channels]
    if undeclared:
        yield advice(
            "channels",
            "a declaration in 'channels', with axes and unit, of each channel of the motion",
            f"{', '.join(undeclared)} not declared; no fitness can read them",
            "channels = {…, "
            + f"{undeclared[0]!r}: Channel(('frames',), 'm', 'description')"
            + "}",
        )
    whole = [index for index in range(COUNT) if index not in motion.failures]
    for name in motion:
        bad = [i for i in whole if not np.isfinite(motion[name][i]).all()]
        if bad:
            yield error(
                "finite values",
                f"{name}: finite numbers for each individual that is not in Motion.failures",
                f"{np.count_nonzero(~np.isfinite(motion[name][bad[0]]))} non-finite values "
                f"in individual {bad[0]}, whose genes are random or at their bounds",
                "prevent overflow and division by 0, or report a reason in Motion.failures",
            )
    if not whole:
        yield error(
            "failures",
            "at least one individual that does not fail",
            f"all failed: {motion.failures[0]}",
            "narrow the bounds of the genome space",
        )
    yield from _check_axis_lengths(body, motion)


def _check_speed(
    body: Organism, space: GenomeSpace, figures: dict[str, float]
) -> Iterator[Finding]:
    """Time individuals alone and in a batch; time a whole population unless that would be slow."""
    genomes = sample_genomes(space, MANY)
    alone = sum(_timed_move(body, genomes[one : one + 1])[1] for one in range(FEW))
    count, (_, taken) = FEW, _timed_move(body, genomes[:FEW])
    # A body that moves whole arrays takes as long for a batch as for one individual. A body that
    # loops takes as long as for all individuals one by one.
    loops = taken >= 2 / 3 * alone
    if not loops or taken < LONG:
        count, (_, taken) = MANY, _timed_move(body, genomes)
    each = taken / count
    figures["individuals_per_second"] = 1 / max(each, 1e-9)
    # The fixed cost of a call is subtracted: bodies that move whole arrays have one, too.
    if (taken - alone / FEW) / (count - 1) > SLOW:
        yield advice(
            "speed",
            f"at most {SLOW} s for each further individual of a population",
            f"{each:.2f} s: 300 generations of 100 take {each * 30000 / 3600:.1f} h on one core",
            "move the whole population at once with NumPy, or compile the loop with Numba",
        )


def sample_motion(entry: Entry, body: Organism) -> Motion:
    """Return the motion of a few individuals, as input for a fitness."""
    return check_motion(entry, body.move(sample_genomes(space_of(entry, body))))
