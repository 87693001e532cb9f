"""The robot itself, with the dimensions of an individual, as MJCF or URDF."""

import json
from pathlib import Path

import numpy as np

from gaitsim.plugin import Exported, GaitsimError, plugin_errors
from gaitsim.plugin.runs import Individual, write_bytes
from gaitsim_hardware.c_code import make_folder
from gaitsim_robot.organism import Robot
from gaitsim_robot.text import compile_model
from gaitsim_robot.urdf import mesh_files, urdf


def check_robot(individual: Individual, format: str) -> str:
    """Return the body of an individual in a format, 'mjcf' or 'urdf'.

    Raises:
        GaitsimError: the body has no such description.
    """
    entry, body = individual.experiment.entries["organism"], individual.body
    with plugin_errors(entry, f"writing its {format.upper()}"):
        text = body.mjcf() if format == "mjcf" else body.urdf()
    if not text:
        raise GaitsimError(
            f"{entry} has no {format.upper()}",
            where=f"--format {format}",
            allowed=f"a body with the method {format}(), such as a robot"
            + (" without mimic joints and closed linkages" if format == "urdf" else ""),
        )
    return text


def export_robot(individual: Individual, format: str, path: Path) -> Exported:
    """Write the body of an individual; the meshes of a URDF are in a folder beside it."""
    text, body, meshes = check_robot(individual, format), individual.body, {}
    notices: tuple[str, ...] = ()
    if isinstance(body, Robot):
        model = compile_model(body.text)
        if format == "urdf" and model.nmesh:
            folder, meshes = f"{path.stem}-meshes", mesh_files(model)
            text = urdf(model, body.anatomy, body._servos, folder)
            make_folder(path.parent / folder)
            for name, data in meshes.items():
                write_bytes(path.parent / folder / name, data, follow=False)
        notices = _notices(body, format)
        joints = f"{len(body.joint_names())} joints, {body.anatomy.mass:.3g} kg"
    else:
        joints = f"{len(body.joint_names())} joints"
    write_bytes(path, text.encode(), follow=False)
    with_meshes = f", {len(meshes)} meshes" if meshes else ""
    return Exported(f"the robot as {format.upper()}: {joints}{with_meshes}", notices)


def _notices(body: Robot, format: str) -> tuple[str, ...]:
    """Return which options play the robot as it was simulated, as the file cannot state them."""
    late = body.simulation.latency
    if format == "mjcf":
        option = f"--set organism.latency={late:g}"
        return (f"MJCF states no latency of servos; play it with {option}",) if late else ()
    pairs = zip(body.joint_names(), np.degrees(body.standing_pose()).tolist(), strict=True)
    stance = ", ".join(f"{json.dumps(name)} = {angle:.6g}" for name, angle in pairs)
    return (
        "URDF states neither the standing pose nor the gains of servos; play it with "
        f"--set organism.servo={body.servo} --set 'organism.stance={{{stance}}}'",
    )
