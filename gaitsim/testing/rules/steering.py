"""Rules for a body that a person steers: equal commands, equal motions, and repeated drives."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from gaitsim.contracts import Array, Genomes, Organism, Steered
from gaitsim.errors import GaitsimError
from gaitsim.testing.report import Finding, error
from gaitsim.testing.rules.common import same

WHOLE, SPLIT = (12,), (1, 4, 7)  # frames after each command, in one call and in several


def check_steering(body: Organism) -> Iterator[Finding]:
    """Check the steered body with the controllers of its package, if there are any."""
    commands, controllers = body.commands(), body.controllers()
    names = body.controller_names()
    if not commands or not {*names} <= {*controllers}:
        return
    needed = {name: controllers[name] for name in names}
    try:
        body.steer(needed)
    except GaitsimError:  # with these options, the body cannot be steered
        return
    whole, parts = (_places(body, needed, split) for split in (WHOLE, SPLIT))
    if isinstance(whole, Finding) or isinstance(parts, Finding):
        yield whole if isinstance(whole, Finding) else parts  # type: ignore[misc]
        return
    steered, places = whole
    if not same(places, parts[1]):
        yield error(
            "steering",
            "the same motion for the same commands, bit for bit, however frames are split",
            "the skeleton differs",
            "compute frame by frame, and keep all state in the Steered",
        )
        return
    if options := steered.drive():
        yield from _check_drive(body, dict(options), needed[names[0]], places)


def _places(
    body: Organism, controllers: dict[str, Genomes], split: Sequence[int]
) -> tuple[Steered, Array] | Finding:
    """Return a body after all of its commands, and the segments in each frame; or what is wrong.

    Args:
        body: body to steer.
        controllers: genomes of its controllers by name.
        split: frames of the calls of `advance` after each command.
    """
    steered: object = body.steer(controllers)
    if not isinstance(steered, Steered):
        wanted = "steer() returns a gaitsim.contracts.Steered"
        return error("steering", wanted, f"a {type(steered).__name__}", "")
    found = []
    for command, frames in product(body.commands(), split):
        if frames == split[0]:
            steered.give(command.name)
        segments = body.skeleton(steered.advance(frames), 0).segments
        if len(segments) != frames:
            return error(
                "steering",
                f"advance({frames}) returns {frames} frames",
                f"{len(segments)} frames",
                "return the new frames alone, without the frame before them",
            )
        found.append(segments)
    return steered, np.concatenate(found)


def _check_drive(
    body: Organism, options: dict[str, object], genome: Genomes, places: Array
) -> Iterator[Finding]:
    """Check that the body repeats a drive from its options."""
    again = type(body).model_validate({**dict(body), **options})
    drawn = body.skeleton(again.move(genome[None].copy()), 0).segments[-len(places) :]
    if not same(np.asarray(drawn, places.dtype), places):
        yield error(
            "steering",
            "the same motion, bit for bit, from move() with the options of drive()",
            "the skeleton differs",
            "make the simulation independent of the length of the drive",
        )
