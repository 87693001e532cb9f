"""Checks of a body: its genome space, its motion, its worlds, and what is drawn of it."""

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from gaitsim.plugin import (
    PRESENT,
    PRESENT_CHANNEL,
    Array,
    Channel,
    Entry,
    GaitsimError,
    Genomes,
    GenomeSpace,
    Measure,
    Motion,
    Organism,
    Rig,
    Skeleton,
    Steered,
    check_world,
    plugin_errors,
    registry,
)
from gaitsim.plugin.runs import WORLD, space_of, starts_of
from gaitsim_testing.finding import advise, require, require_type, require_unchanged
from gaitsim_testing.samples import (
    COUNT,
    first_difference,
    same,
    sample_genomes,
    select_rows,
)

KINDS = ("organism",)

FEW, MANY = 3, 100  # sizes of the timed batches; MANY is a usual population
LONG = 0.2  # a small batch must take this long to estimate the time of a population from it, s
SLOW = 0.5  # time per further individual, s; 300 generations of 100 individuals take 4 hours
WHOLE, SPLIT = (12,), (1, 4, 7)  # frames after each command, in one call and in several
_REAL = "biuf"  # kinds of dtype that are real numbers
_ROUNDING = 1e-4  # tolerance for motions with factors of 1, which may be single-precision
_CHECK_DIMENSIONS = (
    "call gaitsim.contracts.check_dimensions(self.design_space(), self.dimensions, self.evolve, "
    "self.ranges) in a @model_validator(mode='after')"
)
_LENGTHS = 1e-3  # tolerance for the lengths of a rig's segments, relative to the longest one

Set = Callable[..., Organism]


@pytest.fixture(scope="session")
def body(plugin: Any) -> Organism:
    """The body with its options."""
    assert isinstance(plugin, Organism)
    return plugin


@pytest.fixture(scope="session")
def space(entry: Entry, body: Organism) -> GenomeSpace:
    """The genome space, whose genomes belong to it."""
    space = space_of(entry, body)
    labels = len(set(space.labels))
    require(
        space.genes >= 1 and labels == space.genes,
        f"a genome space with {space.genes} genes, {labels} labels",
        "at least one gene, and a unique label for each",
        "return a different name for each gene in GenomeSpace.labels",
    )
    genomes = space.random(50, np.random.default_rng(2))
    require(
        len(genomes) == 50 and space.contains(genomes),
        f"random genomes of shape {np.shape(genomes)}, dtype {genomes.dtype}, or outside the space",
        "random genomes that belong to the space",
        "call repair() at the end of random()",
    )
    return space


@pytest.fixture(scope="session")
def genomes(space: GenomeSpace) -> Genomes:
    """Some genomes, which must not be changed."""
    return sample_genomes(space)


@pytest.fixture(scope="session")
def motion(entry: Entry, body: Organism, genomes: Genomes) -> Motion:
    """The motion of the genomes, with valid channels."""
    with plugin_errors(entry, "moving a population"):
        motion: Any = body.move(genomes.copy())
    require_type("move()", motion, Motion)
    require(
        isinstance(motion.frame_rate, int | float) and 0 < motion.frame_rate < math.inf,
        f"a motion with the frame rate {motion.frame_rate!r}",
        "a frame rate above 0, in Hz",
        "Motion(frames / seconds, …)",
    )
    missing = [name for name in body.channels if name not in motion]
    require(
        not missing,
        f"a motion without {', '.join(missing)}",
        "a motion with every channel of 'channels'",
        "add them to the Motion, or remove them from 'channels'",
    )
    for name in motion:
        _check_channel(name, motion[name], body.channels.get(name))
    return motion  # type: ignore[no-any-return]


def _check_channel(name: str, array: Any, channel: Channel | None) -> None:
    is_array = isinstance(array, np.ndarray)
    require(
        is_array and array.dtype.kind in _REAL,
        f"{name} is {f'of dtype {array.dtype}' if is_array else f'a {type(array).__name__}'}",
        "an array of real numbers or bool",
        "use np.asarray(…)",
    )
    require(
        array.shape[:1] == (COUNT,),
        f"{name} has the shape {array.shape}",
        f"the first axis (population,) = ({COUNT},)",
        "use the first axis for the population, and the second for time",
    )
    if channel is not None:
        require(
            channel.fits(array.shape),
            f"{name} has the shape {array.shape}",
            f"the declared axes {channel.shape}, with a population of {COUNT}",
            "correct the axes in 'channels', or the array",
        )


def test_genome_space(space: GenomeSpace, body: Organism) -> None:
    """Genomes come only from the generator, and `repair` leaves valid ones unchanged."""
    operators: Any = registry.scan("mutation")[0].values()
    advise(
        any(isinstance(space, operator.spaces) for operator in operators),
        f"the genome space is a {type(space).__name__}",
        "a space that an installed mutation supports, such as a RealSpace or a BitSpace",
        "provide a crossover and a mutation with this class in their 'spaces'",
    )
    genomes = space.random(50, np.random.default_rng(2))
    require(
        same(space.repair(genomes), genomes),
        "repair() changes valid genomes",
        "unchanged valid genomes",
        "make 'repair_bits' return repaired genomes unchanged",
    )
    drawn = [one.random(5, np.random.default_rng(3)) for one in (space, space, body.genome_space())]
    require(
        same(drawn[0], drawn[1]) and same(drawn[0], drawn[2]),
        "different genomes from the same generator",
        "the same genomes for each call of genome_space()",
        "draw only from the generator 'rng'",
    )


def test_starts(entry: Entry, body: Organism, space: GenomeSpace) -> None:
    """Start points are valid genomes by printable names."""
    starts_of(entry, body, space)


def test_values(body: Organism, motion: Motion) -> None:
    """Channels are declared and finite, and axes of the same name are equally long."""
    undeclared = [name for name in motion if name not in body.channels]
    advise(
        not undeclared,
        f"{', '.join(undeclared)} not declared; no fitness can read them",
        "a declaration in 'channels', with axes and unit, of each channel of the motion",
        f"channels = {{…, {undeclared[:1]}: Channel(('frames',), 'm', 'description')}}",
    )
    whole = [index for index in range(COUNT) if index not in motion.failures]
    for name in motion:
        bad = [i for i in whole if not np.isfinite(motion[name][i]).all()]
        require(
            not bad,
            f"{name} has non-finite values in the individuals {bad}, whose genes are random or at "
            "their bounds",
            "finite numbers for each individual that is not in Motion.failures",
            "prevent overflow and division by 0, or report a reason in Motion.failures",
        )
    require(
        whole,
        f"all individuals fail: {motion.failures.get(0)}",
        "at least one individual that does not fail",
        "narrow the bounds of the genome space",
    )
    lengths = {"joints": ("joint_names()", len(body.joint_names()))}
    for name, channel in body.channels.items():
        for axis, length in zip(channel.axes, motion[name].shape[1:], strict=True):
            if isinstance(axis, str):
                first, expected = lengths.setdefault(axis, (name, length))
                require(
                    length == expected,
                    f"{name} has {length} {axis}",
                    f"{expected}, as in {first}",
                    "use the same name only for axes of the same length",
                )


def test_determinism(body: Organism, genomes: Genomes, motion: Motion) -> None:
    """Motions do not depend on repetition, order, chunks or threads."""
    everyone = range(len(genomes))
    whole = select_rows(motion, everyone)
    argument = genomes.copy()
    # select_rows reads all channels, and so computes the derived channels.
    again = select_rows(body.move(argument), everyone)
    require_unchanged(same(argument, genomes), "move()", "the genomes")
    name = first_difference(whole, again)
    require(
        not name,
        f"{name} differs when the same genomes move a second time",
        "the same motion for the same genomes, bit for bit",
        "draw random numbers only from a seed that is an option, and keep no state",
    )
    order = list(reversed(everyone))
    for how, rows in {"in reverse order": order, "alone": [2], "in a chunk of two": [4, 1]}.items():
        part = select_rows(body.move(genomes[rows]), range(len(rows)))
        name = first_difference(select_rows(motion, rows), part)
        require(
            not name,
            f"{name} differs when individuals move {how}",
            "each individual's motion depends only on its own genome, bit for bit",
            "use no values of the whole population, such as its mean; a matrix product may "
            "round differently for a different number of rows",
        )
    if body.threads:
        with ThreadPoolExecutor(2) as pool:
            parts = [*pool.map(lambda _: select_rows(body.move(genomes.copy()), everyone), order)]
        name = next(filter(None, (first_difference(whole, part) for part in parts)), "")
        require(
            not name,
            f"{name} differs when two threads move populations concurrently",
            "the same bits, as 'threads' declares",
            "keep no state between calls, or remove 'threads = True'",
        )


@pytest.mark.parametrize("place", [0, -1], ids=["first", "last"])
def test_skeleton(body: Organism, motion: Motion, place: int) -> None:
    """The skeletons of the first and the last individual can be drawn."""
    _check_skeleton(body, motion, range(motion.population)[place])


def _check_skeleton(body: Organism, motion: Motion, individual: int) -> None:
    skeleton: Any = body.skeleton(motion, individual)
    require_type("skeleton()", skeleton, Skeleton)
    points = [skeleton.segments, skeleton.path]
    points += [more for more in (skeleton.contacts, skeleton.poses) if more is not None]
    finite = individual in motion.failures or all(np.isfinite(p).all() for p in points)
    require(
        len(skeleton.segments) and skeleton.names and finite and skeleton.frame_rate > 0,
        f"a skeleton with {len(skeleton.segments)} frames, {len(skeleton.names)} segments, "
        f"{skeleton.frame_rate} Hz{'' if finite else ', non-finite points'}",
        "at least one frame and one segment, finite points, a frame rate above 0",
        "return both ends of each segment in metres, as an array (frames, segments, 2, 3)",
    )
    if skeleton.poses is not None and individual not in motion.failures:
        lengths = np.linalg.norm(skeleton.poses[..., 3:], axis=-1).ravel()
        length = lengths[np.abs(lengths - 1).argmax()]
        require(
            abs(length - 1) <= 1e-3,
            f"a pose of the skeleton with a quaternion of length {length:.3g}",
            "unit quaternions (w, x, y, z)",
            "return the position first, then the quaternion",
        )


def test_rig(body: Organism, motion: Motion) -> None:
    """The rig, if any, lists the body's joints and the skeleton's parts in order."""
    check_rig(body, motion)


def check_rig(body: Organism, motion: Motion) -> None:
    """Check the rig of a body in a motion."""
    rig: Any = body.rig()
    if rig is None:
        return
    require_type("rig()", rig, Rig)
    skeleton = body.skeleton(motion, 0)
    for what, names, expected in (
        ("joints of joint_names()", rig.joints, body.joint_names()),
        ("segments of the skeleton", rig.names, skeleton.names),
        ("contact_names of the skeleton", rig.foot_names, skeleton.contact_names),
        (
            "solids of the skeleton",
            tuple(one.name for one in rig.solids),
            tuple(one.name for one in skeleton.solids),
        ),
    ):
        require(
            tuple(names) == tuple(expected),
            f"a rig with {', '.join(names) or 'none'}",
            f"the {what}, in this order: {', '.join(expected) or 'none'}",
            "use the same names in the rig and in the skeleton",
        )
    if 0 in motion.failures:
        return
    ends = np.diff(rig.segments, axis=1), np.diff(np.asarray(skeleton.segments[0], float), axis=1)
    lengths, shown = (np.linalg.norm(one[:, 0], axis=-1) for one in ends)
    worst = int(np.abs(lengths - shown).argmax())
    require(
        abs(lengths[worst] - shown[worst]) <= _LENGTHS * shown.max(),
        f"a rig whose segment {rig.names[worst]!r} is {lengths[worst]:.4g} m long",
        f"segments as long as the skeleton's, {shown[worst]:.4g} m",
        "return both ends of a segment in the frame of its link",
    )


def test_measures(body: Organism, motion: Motion) -> None:
    """Each measure has one number per individual."""
    for name, measure in body.measures(motion).items():
        require_type(f"measures(), {name}", measure, Measure)
        require(
            np.shape(measure.values) == (motion.population,),
            f"the measure {name} has values of shape {np.shape(measure.values)}",
            f"(population,) = ({motion.population},)",
            "return one number per individual",
        )


def test_play(body: Organism, motion: Motion) -> None:
    """The body can play the joint angles of its own motion."""
    if not body.can_play or "joint_angles" not in motion:
        return
    angles = motion["joint_angles"].copy()
    lent = angles.copy()
    played: Any = body.play(lent)
    require_unchanged(same(lent, angles), "play()", "the joint angles")
    require_type("play()", played, Motion)
    shape = np.shape(played["joint_angles"]) if "joint_angles" in played else ()
    require(
        shape == angles.shape,
        f"play() returns the channel joint_angles with the shape {shape}",
        f"the shape of the argument, {angles.shape}",
        "add the channel to the Motion",
    )


def test_steering(body: Organism) -> None:
    """A steered body moves identically however frames are split, and repeats its drive."""
    check_steering(body)


def check_steering(body: Organism) -> None:
    """Check a steered body with the controllers of its package, if there are any."""
    controllers, names = body.controllers(), body.controller_names()
    if not body.commands() or not {*names} <= {*controllers}:
        return
    needed = {name: controllers[name] for name in names}
    try:
        body.steer(needed)
    except GaitsimError:  # with these options, the body cannot be steered
        return
    (steered, places), (_, parts) = (_steer(body, needed, split) for split in (WHOLE, SPLIT))
    require(
        same(places, parts),
        "the skeleton differs when the frames are split into other calls of advance()",
        "the same motion for the same commands, bit for bit, however frames are split",
        "compute frame by frame, and keep all state in the Steered",
    )
    if options := steered.drive():
        again = type(body).model_validate({**dict(body), **options})
        genome = needed[names[0]][None].copy()
        drawn = body.skeleton(again.move(genome), 0).segments[-len(places) :]
        require(
            same(np.asarray(drawn, places.dtype), places),
            "the skeleton differs when move() repeats a drive",
            "the same motion, bit for bit, from move() with the options of drive()",
            "make the simulation independent of the length of the drive",
        )


def _steer(
    body: Organism, controllers: dict[str, Genomes], split: Sequence[int]
) -> tuple[Steered, Array]:
    """Return a body after all of its commands, and the segments in each frame.

    Args:
        body: body to steer.
        controllers: genomes of its controllers by name.
        split: frames of the calls of `advance` after each command.
    """
    steered: Any = body.steer(controllers)
    require_type("steer()", steered, Steered)
    found = []
    for command, frames in product(body.commands(), split):
        if frames == split[0]:
            steered.give(command.name)
        segments = body.skeleton(steered.advance(frames), 0).segments
        require(
            len(segments) == frames,
            f"advance({frames}) returns {len(segments)} frames",
            f"{frames} frames",
            "return the new frames alone, without the frame before them",
        )
        found.append(segments)
    return steered, np.concatenate(found)


def test_damage(body: Organism, genomes: Genomes, motion: Motion) -> None:
    """A body without its first leg accepts the genomes of the intact body."""
    legs = body.leg_joints()
    if "damage" not in type(body).model_fields or len(legs) < 2 or dict(body).get("damage"):
        return
    lost = f"{next(iter(legs))} lost"
    damaged = type(body).model_validate({**dict(body), "damage": (lost,)})
    moved = _check_same_shapes(body, damaged, f"with damage = {lost!r}", genomes, motion)
    _check_skeleton(damaged, moved, 0)


def _check_same_shapes(
    body: Organism, other: Organism, how: str, genomes: Genomes, motion: Motion
) -> Motion:
    """Return the motion of a variant of a body, which must have the same genomes and shapes."""
    drawn = [one.genome_space().random(5, np.random.default_rng(3)) for one in (body, other)]
    require(
        same(*drawn),
        f"a different genome space {how}",
        "the same genome space",
        "make genome_space() independent of this option",
    )
    moved = other.move(genomes.copy())
    for name in motion:
        require(
            np.shape(moved[name]) == np.shape(motion[name]),
            f"{name} has the shape {np.shape(moved[name])} {how}",
            f"the same shape as otherwise, {np.shape(motion[name])}",
            "keep the frames, joints and feet in the channels",
        )
    return moved


def test_worlds(body: Organism, genomes: Genomes, motion: Motion) -> None:
    """Conditions are valid, nominal ones change nothing, and the option `world` is validated."""
    conditions = body.conditions()
    for world in body.checks():
        check_world(world, conditions)
    if not conditions:
        return
    declaration = "dict[str, float] = option({}, WORLD_HELP)"
    require(
        WORLD in type(body).model_fields,
        f"the body has conditions, but no option {WORLD!r}",
        f"the option {WORLD!r}",
        f"declare {WORLD}: {declaration}",
    )
    for name, one in conditions.items():
        usual = one.least <= one.low <= one.high <= one.most
        require(
            usual and one.least <= one.nominal <= one.most,
            f"the condition {name} is {one!r}",
            "low ≤ high, and low, high and nominal between least and most",
            "correct the condition",
        )

    def with_world(world: dict[str, float]) -> Organism:
        return type(body).model_validate({**dict(body), WORLD: world})

    nominal = {name: one.nominal for name, one in conditions.items()}
    require(
        same(with_world(nominal | dict(body)[WORLD]).move(genomes.copy()), motion),
        "a different motion with all nominal values set than with none set",
        "the same motion",
        "make sure that nominal values do not change a single bit",
    )
    name, one = next(iter(conditions.items()))
    wrong = [{name: value} for value in (one.least - 1, one.most + 1) if math.isfinite(value)]
    for world in ({f"no-{name}": one.nominal}, *wrong):
        try:
            with_world(world)
        except (ValidationError, GaitsimError):
            continue
        require(
            False,
            f"the invalid world {world} is accepted",
            f"an error for unknown conditions, and for values outside {one.least:g} to "
            f"{one.most:g} of {name!r}",
            "call gaitsim.contracts.check_world(self.world, self.conditions()) in a "
            "@model_validator(mode='after')",
        )
    far = {
        name: one.low if one.low != one.nominal else one.high for name, one in conditions.items()
    }
    _check_same_shapes(body, with_world({**far, "seed": 1.0}), "in another world", genomes, motion)


def test_dimensions(body: Organism, genomes: Genomes, motion: Motion) -> None:
    """Dimensions have sensible ranges and validated options, and factors of 1 change nothing."""
    space, options = body.design_space(), type(body).model_fields
    if not space:
        return
    for name in ("dimensions", "evolve", "ranges"):
        require(
            name in options,
            f"the body has dimensions, but no option {name!r}",
            "the options dimensions, evolve and ranges",
            "declare them as the docstring of design_space() shows",
        )
    for name, one in space.items():
        require(
            0 < one.least <= one.low < 1 < one.high <= one.most < math.inf
            and 0 < one.nominal < math.inf,
            f"the dimension {name} is {one!r}",
            "least ≤ low < 1 < high ≤ most, all above 0 and finite, and a nominal value above 0",
            "correct the dimension",
        )
    free = [name for name in space if name not in {*dict(body)["evolve"]}]
    ones = dict.fromkeys(free, 1.0) | dict(body)["dimensions"]
    again = _with_dimensions(body, dimensions=ones).move(genomes.copy())
    for name, channel in body.channels.items():
        if body.dynamic and not channel.over_time:
            continue
        frames = slice(1) if body.dynamic else ...  # rounding grows in a simulation
        values, others = (np.asarray(each[name], np.float64)[:, frames] for each in (motion, again))
        require(
            np.allclose(values, others, rtol=_ROUNDING, atol=_ROUNDING),
            f"{name} differs with a factor of 1 for each dimension",
            "the same motion up to rounding",
            "multiply the nominal values by the factors",
        )
    name, one = next(iter(space.items()))
    for key, wrong in (
        ("dimensions", {f"no-{name}": 1.0}),
        ("dimensions", {name: 2 * one.most}),
        ("evolve", [f"no-{name}"]),
        ("ranges", {f"no-{name}": (0.9, 1.1)}),
        ("evolve", [name, name]),
    ):
        try:
            _with_dimensions(body, **{key: wrong})
        except (ValidationError, GaitsimError) as error:
            told = f"{error} {getattr(error, 'allowed', '')}"
            require(
                wrong != {f"no-{name}": 1.0} or name in told.replace(f"no-{name}", ""),
                f"the error for an unknown dimension is {told[:200]!r}",
                "an error that lists the dimensions",
                _CHECK_DIMENSIONS,
            )
            continue
        require(
            False,
            f"{key} = {wrong!r} is accepted",
            "an error for unknown dimensions, for those listed twice, and for factors outside "
            f"{one.least:g} to {one.most:g} of {name!r}",
            _CHECK_DIMENSIONS,
        )


def _with_dimensions(body: Organism, **options: Any) -> Organism:
    return type(body).model_validate({**dict(body), **options})


def test_evolving_dimensions(entry: Entry, body: Organism, space: GenomeSpace) -> None:
    """Each individual moves and is drawn with its own dimensions, which are its last genes."""
    dimensions = body.design_space()
    options = dict(body)
    if not dimensions or options.get("evolve") or options.get("dimensions"):
        return
    names = [*dimensions][:2]
    evolving = _with_dimensions(body, evolve=names)
    own_space = space_of(entry, evolving)
    last = own_space.random(200, np.random.default_rng(4))[:, -len(names) :]
    low, high = ([getattr(dimensions[name], end) for name in names] for end in ("low", "high"))
    require(
        own_space.genes == space.genes + len(names)
        and (last >= low).all()
        and (last <= high).all()
        and (np.ptp(last, axis=0) > 0).all(),
        f"a genome of {own_space.genes} genes with evolve = {names}, {space.genes} without",
        f"one more gene for each of them at the end, a factor from {low} to {high}",
        "append the groups of gaitsim.plugin.toolkit.dimension_genes(…)",
    )
    starts_of(entry, evolving, own_space)
    genomes = own_space.random(3, np.random.default_rng(4))
    genomes[:2, -len(names) :] = low, high
    genomes = own_space.repair(genomes)
    motion = evolving.move(genomes.copy())
    require(
        "dimensions" in motion and np.array_equal(motion["dimensions"], genomes[:, -len(names) :]),
        "a motion without the channel 'dimensions', or with other factors than the genes",
        "the factors of the dimensions that evolve, (population, dimensions)",
        "motion.add('dimensions', …), and channels = EvolvingChannels(…)",
    )
    part = select_rows(evolving.move(genomes[1:].copy()), range(2))
    name = first_difference(select_rows(motion, [1, 2]), part)
    require(
        not name,
        f"{name} differs when individuals with their own dimensions move in another chunk",
        "each individual's motion depends only on its own genome, bit for bit",
        "use the dimensions of each individual, not those of the whole population",
    )
    lengths = []
    for index in range(len(genomes)):
        if index in motion.failures:
            continue
        own, genes = evolving.embody(genomes[index].copy())
        moved = own.move(genes[None].copy())
        alone, among = select_rows(moved, [0]), select_rows(motion, [index])
        del among["dimensions"]
        name = first_difference(alone, among)
        require(
            not name and own.genome_space().genes == len(genes) == space.genes,
            f"{name or 'the genome'} of the body from embody() differs from the individual's",
            "a body with the individual's dimensions, which moves exactly like it",
            "embody() sets the option 'dimensions' and returns the rest of the genes",
        )
        drawn, shown = evolving.skeleton(motion, index), own.skeleton(moved, 0)
        require(
            same(drawn, shown),
            "the skeleton of an individual differs from that of the body from embody()",
            "a drawing with the individual's own dimensions",
            "in skeleton(), draw self.embody(motion['dimensions'][individual])[0]",
        )
        ends = np.diff(np.asarray(drawn.segments[0], np.float64), axis=1)[:, 0]
        lengths.append(np.linalg.norm(ends, axis=-1))
    require(
        len(lengths) < 2 or not np.allclose(lengths[0], lengths[1], rtol=_LENGTHS),
        f"skeletons of the same lengths for individuals that differ in {', '.join(names)}",
        "segments with the lengths of each individual",
        "draw the segments from the dimensions",
    )


def test_joints_that_differ(body: Organism, motion: Motion, genomes: Genomes) -> None:
    """Joints of the channel `present` are those of the individual's own body; padding is 0."""
    if PRESENT not in body.channels:
        return
    require(
        body.channels[PRESENT] == PRESENT_CHANNEL and motion[PRESENT].dtype == np.bool_,
        f"the channel {PRESENT!r} is {body.channels[PRESENT]}, of {motion[PRESENT].dtype}",
        f"{PRESENT_CHANNEL}, of bool",
        "declare it as gaitsim.plugin.PRESENT_CHANNEL",
    )
    over_joints = [
        (name, channel.axes.index("joints"))
        for name, channel in body.channels.items()
        if "joints" in channel.axes
    ]
    for index in range(len(genomes)):
        if index in motion.failures:
            continue
        own, genes = body.embody(genomes[index].copy())
        count, present = len(own.joint_names()), motion[PRESENT][index]
        require(
            present[:count].all() and not present[count:].any(),
            f"an individual whose body has {count} joints has {present.sum()} in {PRESENT!r}",
            "True for the joints of the body from embody(), which come first",
            "count the joints of each individual's own body",
        )
        moved = own.move(genes[None].copy())
        for name, axis in over_joints:
            padded = np.moveaxis(motion[name][index], axis, 0)
            require(
                same(padded[:count], np.moveaxis(moved[name][0], axis, 0)[:count])
                and not padded[count:].any(),
                f"{name} of a joint that is padded, or of the body from embody(), differs",
                "0 for joints that the individual lacks, and its own motion for the others",
                "fill arrays with np.zeros(…), and move each individual with its own body",
            )


def test_speed(body: Organism, space: GenomeSpace, record_property: Callable[..., None]) -> None:
    """Further individuals are quick; the speed is that of a whole population, if it is not slow."""
    genomes = sample_genomes(space, MANY)
    alone = sum(_time_move(body, genomes[one : one + 1]) for one in range(FEW))
    count, taken = FEW, _time_move(body, genomes[:FEW])
    # A body that moves whole arrays takes as long for a batch as for one individual. A body that
    # loops takes as long as for all individuals one by one.
    loops = taken >= 2 / 3 * alone
    if not loops or taken < LONG:
        count, taken = MANY, _time_move(body, genomes)
    each = taken / count
    record_property("rate", 1 / max(each, 1e-9))
    # The fixed cost of a call is subtracted: bodies that move whole arrays have one, too.
    advise(
        (taken - alone / FEW) / (count - 1) <= SLOW,
        f"{each:.2f} s: 300 generations of 100 take {each * 30000 / 3600:.1f} h on one core",
        f"at most {SLOW} s for each further individual of a population",
        "move the whole population at once with NumPy, or compile the loop with Numba",
    )


def _time_move(body: Organism, genomes: Genomes) -> float:
    start = time.perf_counter()
    body.move(genomes.copy())
    return time.perf_counter() - start
