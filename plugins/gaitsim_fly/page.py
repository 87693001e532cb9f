"""Data of a fly for the scripts in `assets`, which simulate it in a web page."""

from collections.abc import Mapping
from importlib import resources
from typing import Any

import numpy as np

from gaitsim.plugin import Genomes, SteeringPage
from gaitsim_fly import assets, flight
from gaitsim_fly.mechanics import Mechanics
from gaitsim_fly.options import FlyOptions

SHAPE = ("length", "width", "height", "span", "chord")
REGISTER = "gaitsim.registerSteering(steeredFly);"


def page(fly: FlyOptions, controllers: Mapping[str, Genomes]) -> SteeringPage:
    """Return the script and the data with which a web page simulates a steered fly.

    Args:
        fly: body and network.
        controllers: genome (genes,) of each command.
    """
    from gaitsim_fly.steering import BLEND, COMMANDS, LEASH, NAMES, START, controller_genomes

    data = {
        "own": mechanics_data(fly.mechanics(fly.world)),
        "control": control_data(fly),
        "shape": {name: getattr(fly, name) for name in SHAPE},
        "speeds": [fly.course_speeds(name).tolist() for name in NAMES],
        "commands": [{"name": one.name, "key": one.key, "help": one.help} for one in COMMANDS],
        "names": list(NAMES),
        "controllers": controller_genomes(fly, controllers).tolist(),
        "interval": fly.control_step,
        "blend": BLEND,
        "leash": LEASH,
        "altitude": START,
    }
    return SteeringPage(f"{scripts()}\n{REGISTER}", data)


def scripts() -> str:
    """Return the scripts of `assets`, joined in the order in which they run."""
    files = resources.files(assets)
    return "\n".join(files.joinpath(name).read_text("utf-8") for name in assets.SCRIPTS)


def mechanics_data(own: Mechanics) -> dict[str, Any]:
    """Return body, wings and air as a `Mechanics` of flight.js."""
    constants = np.zeros(flight.CONSTANTS)
    own.fill(constants)
    c = constants.tolist()
    return {
        "inverseMass": c[flight.INVERSE_MASS],
        "gravity": c[flight.GRAVITY],
        "inverseInertia": c[flight.INVERSE_INERTIA_X : flight.INVERSE_INERTIA_Z + 1],
        "faces": c[flight.BODY_X : flight.BODY_Z + 1],
        "wing": c[flight.WING],
        "hinge": c[flight.HINGE],
        "arm": c[flight.ARM],
        "wingSpeed": c[flight.WING_SPEED],
        "wind": c[flight.WIND_X : flight.WIND_Y + 1],
    }


def control_data(fly: FlyOptions) -> dict[str, Any]:
    """Return the networks' layers, limits, time steps and scales as a `Control` of control.js."""
    return {
        "layers": list(fly.layers),
        "activation": fly.activation,
        "limits": np.radians([fly.flap_limit, fly.pitch_limit, fly.sweep_limit]).tolist(),
        "dt": fly.dt,
        "steps": round(fly.control_step / fly.dt),
        "positionScale": fly.position_scale,
        "velocityScale": fly.velocity_scale,
        "spinScale": fly.spin_scale,
    }
