"""Pages on which users steer a body."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gaitsim.plugin import GaitsimError, Genomes, SteeringPage, contract_error, plugin_errors
from gaitsim.plugin.gait import check_folder
from gaitsim.plugin.pictures import Clip
from gaitsim.plugin.runs import Experiment, SteeredDrive, write_bytes
from gaitsim_page.clips import body_data
from gaitsim_page.document import asset, document, program_version
from gaitsim_page.player import themes

SCRIPTS = ("pad.js", "steering.js")
DESCRIPTION = "Each key selects an evolved network that controls the body."
POSE_SECONDS = 0.5  # seconds of motion from which the drawn shape of the body is derived


def write_page(experiment: Experiment, controllers: Mapping[str, Genomes], path: Path) -> str:
    """Write a page that steers a body; return a one-line description of the file.

    Args:
        experiment: experiment with the body.
        controllers: genome (genes,) of each command's network.
        path: path of the file.
    """
    check_folder(path)
    data = page(experiment, controllers)
    write_bytes(path, data)
    return f"{len(controllers)} commands, {len(data) / 1e3:,.0f} kB, for any browser"


def page(experiment: Experiment, controllers: Mapping[str, Genomes]) -> bytes:
    """Return the page that `write_page` writes, in UTF-8."""
    entry = experiment.entries["organism"]
    with plugin_errors(entry, "creating its steering page"):
        own = experiment.organism.steering_page(controllers)
    if own is None:
        raise GaitsimError(
            f"web pages cannot simulate the body {entry.name!r}",
            where=f"experiment {experiment.name}",
            allowed="a body with the method steering_page()",
            remedy="steer it in a terminal, save the drive, and export that run with --format html",
        )
    if not isinstance(own, SteeringPage):
        raise contract_error(
            entry, f"returned a {type(own).__name__} from steering_page()", "a SteeringPage or None"
        )
    with plugin_errors(entry, "storing the data of its steering page"):
        json.dumps(own.data, allow_nan=False)
    drive = SteeredDrive(experiment, controllers)
    drive.advance_to(POSE_SECONDS)
    data: dict[str, Any] = {
        "title": f"Steer the {entry.name}",
        "description": DESCRIPTION,
        "theme": themes(),
        "made": program_version(),
        "clip": body_data(Clip(drive.skeleton)),
        "commands": [asdict(command) for command in drive.commands],
        "body": own.data,
    }
    return document(
        data["title"],
        "steering",
        data,
        ["\n".join(map(asset, SCRIPTS)), own.script],
        description=data["description"],
    )
