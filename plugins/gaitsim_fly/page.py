"""A fly as data, for the scripts in `assets` that fly it in a web page."""

from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim_fly import assets, flight
from gaitsim_fly.mechanics import Mechanics

if TYPE_CHECKING:
    from gaitsim_fly.organism import Fly


def scripts() -> str:
    """Return the scripts of `assets` as one, in a scope of its own."""
    files = resources.files(assets)
    texts = [files.joinpath(name).read_text("utf-8") for name in assets.SCRIPTS]
    return "\n".join(["(function () {", *texts, "})();"])


def mechanics_data(own: Mechanics) -> dict[str, Any]:
    """Return mass, air and wings as the type `Mechanics` of flight.js."""
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


def control_data(fly: "Fly") -> dict[str, Any]:
    """Return what the networks see and command as the type `Control` of control.js."""
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
