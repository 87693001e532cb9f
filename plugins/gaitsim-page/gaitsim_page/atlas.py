"""Pages of an archive: a map of its cells, and the gait of each cell in 3D."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Genomes, Rig, RunError, contract_error, plugin_errors
from gaitsim.plugin.gait import check_folder
from gaitsim.plugin.pictures import (
    VIRIDIS,
    ArchiveView,
    clip_of,
    colour_scale_low,
    require_archive,
)
from gaitsim.plugin.runs import (
    Experiment,
    Individual,
    Member,
    RunSnapshot,
    command,
    write_bytes,
)
from gaitsim_page.clips import body_data
from gaitsim_page.document import asset, document, program_version
from gaitsim_page.gaits import gaits_data, map_genomes, strides_data, strides_of
from gaitsim_page.packing import Packed, pack, pack_json
from gaitsim_page.player import check_size, themes

SCRIPTS = ("rig.js", "gaits.js", "cells.js", "gait_list.js", "atlas.js")
_PRINTED_STEP = 1e-4  # rounding of numbers that are only printed, as a share of their range
# Fields of a body in motion that a page of many gaits does not need.
_CAPTION_FIELDS = ("title", "details", "tag", "said")
_MOTION_FIELDS = ("frameRate", "frames", "points", "poses", "centre", "ground")

Json = dict[str, Any]


def write_atlas(
    run: RunSnapshot,
    path: Path,
    workers: int | None = None,
    *,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda done: None,
) -> str:
    """Write a page of a run's archive; return a one-line description of the file.

    Args:
        run: run whose search keeps an archive.
        path: path of the file.
        workers: number of workers; None chooses the body's default.
        begin: function called with the number of gaits.
        advance: function called with the number of gaits finished since the last call.
    """
    check_folder(path)
    data = atlas_data(run, workers, begin=begin, advance=advance)
    scripts = ["\n".join(asset(name) for name in SCRIPTS)]
    page = document(
        data["title"],
        "atlas",
        data,
        scripts,
        description=data["description"],
    )
    check_size(page, path, "evolve an archive with fewer cells")
    write_bytes(path, page)
    gaits = data["gaits"]
    how = "no motions, which need joint angles and a rig"
    if gaits is not None:
        own = "a body for each, " if data["bodies"] else ""
        how = f"{own}joint angles within {gaits['error']:.2g} rad"
    gaits_of = f"{data['count']:,} gait{'s' * (data['count'] != 1)}"
    return f"{gaits_of}, {how}, {len(page) / 1e6:.2f} MB, for any browser"


def atlas_data(
    run: RunSnapshot,
    workers: int | None = None,
    *,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda done: None,
) -> Json:
    """Return the data of the page that `write_atlas` writes."""
    best = run.individual(Member(1)) if run.experiment.search.keeps else run.individual()
    require_archive(best)
    members, view = run.members, ArchiveView.of(run.members)
    if members is None or view is None or view.best is None:
        raise RunError(
            f"the run {run.path} has no archive cells to show",
            allowed="a run of a search that provides the cells of its archive",
        )
    best = run.individual(Member(view.best))
    shared = best.embodied is best
    rig = rig_of(best)
    low, below = colour_scale_low(members.scores)
    gaits, bodies = None, None
    if rig is not None and shared:
        gaits = gaits_data(best.experiment, members.genomes, workers, begin=begin, advance=advance)
    elif rig is not None and best.joint_angles is not None:
        begin(len(members.genomes))
        gaits, bodies = _own_gaits(best.experiment, members.genomes, workers, advance)
    name = run.path.resolve().name
    return {
        "title": name,
        "description": best.experiment.description,
        "made": program_version(),
        "theme": themes(),
        "count": len(members.scores),
        "filled": view.coverage,
        "generation": run.generation,
        "command": command("play", name, "--member"),
        "unit": best.experiment.fitness.unit,
        "scores": _row(members.scores),
        "colours": list(VIRIDIS),
        "lowest": low,
        "below": below,
        "axes": [_axis(view, axis, best.unit_of(axis)) for axis in view.names],
        "pairs": [[view.names.index(one) for one in pair] for pair in view.pairs],
        "raster": _raster(view),
        "gaits": gaits,
        "body": None if gaits is None or rig is None or bodies else rigged_body(best, rig),
        "bodies": bodies,
    }


def rig_of(individual: Individual) -> Rig | None:
    """Return the rig of an individual's body; None if the body has no rig."""
    entry = individual.experiment.entries["organism"]
    with plugin_errors(entry, "describing the body's links"):
        rig: object = individual.body.rig()
    if not (rig is None or isinstance(rig, Rig)):
        raise contract_error(entry, f"returned a {type(rig).__name__} from rig()", "a Rig or None")
    return rig


def _own_gaits(
    experiment: Experiment,
    genomes: Genomes,
    workers: int | None,
    advance: Callable[[int], object],
) -> tuple[Json, str]:
    """Return strides with their numbers of joints, and the packed bodies of individuals."""
    found = map_genomes(experiment, genomes, _bodies_and_strides, workers, advance)
    bodies, rates, counts, *strides = found
    data = {"frameRate": float(rates[0]), "counts": pack(counts[None], 1.0)}
    return data | strides_data(*strides), pack_json(bodies.tolist())


def _bodies_and_strides(experiment: Experiment, genomes: Genomes) -> tuple[NDArray[Any], ...]:
    """Return the bodies, frame rates and numbers of joints of individuals, and their strides.

    The body of an individual without a rig is None, and its stride has no joints.
    """
    ones = [Individual(experiment, 0.0, {}, genome=genome) for genome in genomes]
    bodies, motions = np.empty(len(ones), object), []
    for number, one in enumerate(ones):
        rig = rig_of(one)
        bodies[number] = None if rig is None else rigged_body(one, rig)
        angles = None if rig is None else one.joint_angles
        if angles is None or not angles.size:
            angles = np.zeros((1, 0))
        motions.append(np.nan_to_num(angles))
    rates = np.array([one.motion.frame_rate for one in ones])
    counts = np.array([angles.shape[1] for angles in motions])
    return bodies, rates, counts, *strides_of(motions)


def _axis(view: ArchiveView, name: str, unit: str) -> Json:
    """Return an axis: its parts in the map, and each member's value and part."""
    borders = view.part_borders(name)
    return {
        "name": name,
        "unit": unit,
        "borders": borders.tolist(),
        "places": pack(view.part_indices(name, borders)[None], 1.0),
        "values": _row(view.members.values[name]),
    }


def _raster(view: ArchiveView) -> Packed | None:
    """Return the numbers of the members on a map of Voronoi cells, −1 if empty.

    The result is None for other archives, and for tessellations of more or fewer than two axes.
    """
    if view.members.centroids is None or len(view.names) != 2:
        return None
    return pack(view.panel(*view.names).members, 1.0)


def _row(values: Any) -> Packed:
    """Return one number per member in a single row, as neighbours in an archive are dissimilar."""
    span = float(np.ptp(values)) or float(np.abs(values).max()) or 1.0
    return pack(np.asarray(values)[None], 10.0 ** np.floor(np.log10(span * _PRINTED_STEP)))


def rigged_body(individual: Individual, rig: Rig) -> Json:
    """Return the drawn shape and the rig of a body."""
    experiment, body, skeleton = individual.experiment, individual.body, individual.skeleton
    if (rig.joints, rig.names) != (body.joint_names(), skeleton.names):
        raise contract_error(
            experiment.entries["organism"],
            "has a rig whose joints or segments differ from the body's",
            "the joints of joint_names() and the segments of the skeleton, in the same order",
        )
    found, hidden = body_data(clip_of(individual)), _CAPTION_FIELDS + _MOTION_FIELDS
    clip = {key: value for key, value in found.items() if key not in hidden}
    contacts = skeleton.contacts
    if clip["feet"]:
        clip["feet"] = {k: v for k, v in clip["feet"].items() if k not in ("points", "touching")}
    index = {link.name: number for number, link in enumerate(rig.links)}
    solids = [] if rig.solid_poses is None else rig.solid_poses.tolist()
    feet = [] if rig.feet is None else rig.feet.tolist()
    # A foot may be the centre of a ball, which is above the ground in stance.
    stand = 0.0 if contacts is None else float(np.median(contacts[..., 2].min(axis=1)))
    return {
        "clip": clip,
        "stand": max(stand, 0.0),
        "rests": not body.dynamic,
        "links": [
            {
                "parent": index.get(link.parent, -1),
                "origin": link.origin,
                "rotation": link.rotation,
                "joint": rig.joints.index(link.joint) if link.joint else -1,
                "axis": link.axis,
            }
            for link in rig.links
        ],
        "segments": [
            [index[link], *ends]
            for link, ends in zip(rig.segment_links, rig.segments.tolist(), strict=True)
        ],
        "solids": [[index[link], pose] for link, pose in zip(rig.solid_links, solids, strict=True)],
        "feet": [[index[link], point] for link, point in zip(rig.foot_links, feet, strict=True)],
    }
