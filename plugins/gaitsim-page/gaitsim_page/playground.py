"""The page that evolves a spider in the browser, with the bits of the same run in gaitsim."""

import base64
import json
import math
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.plugin import RealSpace
from gaitsim.plugin.gait import check_folder
from gaitsim.plugin.runs import (
    Challenge,
    Experiment,
    Individual,
    dictionary,
    load_experiment,
    write_bytes,
)
from gaitsim_page import assets
from gaitsim_page.atlas import rig_of, rigged_body
from gaitsim_page.document import asset, document, program_version
from gaitsim_page.packing import deflated
from gaitsim_page.player import themes
from gaitsim_spider import body
from gaitsim_spider.damage import damaged_anatomy

PRESET = "spider-genetic"
POPULATION = 50
COMPARED = 100  # generation after which the page shows the run's fingerprint
SCRIPTS = ("rig.js", "playground.js")
WORKER = ("codes.js", "evolver.js", "evolver_worker.js")
TITLE = "Watch a spider learn to walk"
DESCRIPTION = (
    f"{POPULATION} spiders begin with random movements. The best walkers have children, and the "
    "champion of each generation walks here."
)


def write_page(path: Path, seed: int = 0) -> str:
    """Write the page; return a one-line description of the file.

    Args:
        path: path of the file.
        seed: seed of the first run on the page.
    """
    check_folder(path)
    data = page(seed)
    write_bytes(path, data)
    return f"evolves a spider in any browser, {len(data) / 1e3:,.0f} kB"


def page(seed: int = 0) -> bytes:
    """Return the page that `write_page` writes, in UTF-8."""
    found = experiment(seed)
    start = _start(found)
    rig = rig_of(start)
    assert rig is not None, "the spider has a rig"
    fields = type(found.fitness).model_fields
    data = {
        "title": TITLE,
        "description": DESCRIPTION,
        "theme": themes(),
        "made": program_version(),
        "preset": PRESET,
        "seed": seed,
        "population": POPULATION,
        "generations": found.evolution.generations,
        "compared": COMPARED,
        "frameRate": body.FRAME_RATE,
        "weights": found.fitness.model_dump(),
        "help": {name: one.description for name, one in fields.items()},
        "body": rigged_body(start, rig),
    }
    scripts = [f"const WORKER = {json.dumps(worker_script(found))};", *map(asset, SCRIPTS)]
    return document(
        TITLE, "playground", data, ["\n".join(scripts)], description=DESCRIPTION, computes=True
    )


def experiment(seed: int = 0) -> Experiment:
    """Return the experiment with which the page begins."""
    changes = {"seed": seed, "evolution.population": POPULATION, "search.start": "random"}
    return load_experiment(PRESET, changes)


def worker_script(found: Experiment) -> str:
    """Return the script of the page's worker: its data, the search, and the codes."""
    data = json.dumps(_worker_data(found), allow_nan=False)
    return "\n".join(['"use strict";', f"const DATA = {data};", *map(asset, WORKER)])


def _start(found: Experiment) -> Individual:
    """Return the tetrapod made by hand."""
    [start] = found.starts().values()
    return Individual(found, 0.0, {}, 1, np.asarray(start, np.float64))


def _worker_data(found: Experiment) -> dict[str, Any]:
    from gaitsim_page.kernels import FILE, MEMORY

    space, start = found.space(), _start(found)
    assert isinstance(space, RealSpace)
    assert space.periodic is not None
    assert start.genome is not None
    challenge, options = Challenge.of(start), found.organism.model_dump()
    return {
        "module": base64.b64encode((files(assets) / FILE).read_bytes()).decode(),
        "size": MEMORY.itemsize,
        "fields": {name: _field(*one[:2]) for name, one in (MEMORY.fields or {}).items()},
        "memory": deflated(_memory(options["frequency"]).tobytes()),
        "legs": deflated(_legs().tobytes()),
        "legNames": body.LEGS,
        "lower": space.lower.tolist(),
        "upper": space.upper.tolist(),
        "periodic": space.periodic.tolist(),
        "start": start.genome.tolist(),
        "frameRate": body.FRAME_RATE,
        "frames": body.FRAMES,
        "stride": round(body.FRAME_RATE / options["frequency"]),
        "population": POPULATION,
        "generations": found.evolution.generations,
        "compared": COMPARED,
        **{kind: found.plugin(kind).model_dump() for kind in ("search", *found.search.operators)},
        "weights": found.fitness.model_dump(),
        "experiment": challenge.text,
        "versions": json.dumps(dict(challenge.versions), separators=(",", ":")),
        "dictionary": dictionary().decode(),
    }


def _field(dtype: np.dtype[Any], place: int) -> tuple[int, int, str]:
    """Return the place, the size and the type of the numbers of a field of the memory."""
    base, shape = dtype.subdtype or (dtype, ())
    return place, math.prod(shape), base.str[1:]


def _memory(frequency: float) -> np.ndarray[Any, Any]:
    """Return the memory of the kernels with all that never changes."""
    from gaitsim.plugin.toolkit import normal_strips as strips
    from gaitsim_page.kernels import MEMORY
    from gaitsim_spider.sums import high_pass
    from gaitsim_spider.waves import unit_waves

    memory = np.zeros((), MEMORY)
    step = 2 * math.pi * frequency / body.FRAME_RATE
    memory["sine"], memory["cosine"] = unit_waves(step, body.FRAMES)
    memory["gain"], memory["poles"] = high_pass(body.FRAME_RATE)
    memory["widths"], memory["limits"], memory["heights"] = strips()
    return memory


def _legs() -> np.ndarray[Any, Any]:
    """Return the kernels' data of the intact legs, and of those without each leg, float32."""
    damages = ((), *((f"{leg} lost",) for leg in body.LEGS))
    parts = (damaged_anatomy(damage).legs for damage in damages)
    return np.array([np.concatenate([part.ravel() for part in legs]) for legs in parts])
