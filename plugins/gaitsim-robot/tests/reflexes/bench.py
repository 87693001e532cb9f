"""A reflex on a bench: observations by hand, without a body."""

import numpy as np

from gaitsim.contracts import Inputs, Legs, Observation

FEET = np.array([[0.1, 0.08], [0.1, -0.08], [-0.1, 0.08], [-0.1, -0.08]])
LEGS = Legs(("FL", "FR", "HL", "HR"), FEET, 0.15, 8)
INTERVAL = 0.02


def observation(population=1, legs=4, **parts):
    """Return an observation of level bodies that walk straight, except for the given parts."""
    command = np.tile([0.2, 0.0, 0.0, 0.0], (population, 1))
    default = {
        "orientation": np.zeros((population, 3)),
        "rates": np.zeros((population, 3)),
        "contacts": np.ones((population, legs)),
        "load": np.full((population, legs), 1 / legs),
        "joints": np.zeros((population, LEGS.joints)),
        "command": command,
        "heading": np.zeros(population),
        "phase": np.zeros((population, legs)),
        "duty": np.full((population, 1), 0.5),
    }
    given = {name: np.asarray(value, float) for name, value in parts.items()}
    return Observation(**{**default, **given})


def inputs_of(seen):
    """Return the inputs before any reflex."""
    return Inputs.unchanged(seen.command, seen.phase.shape[1])


def start(reflex, population=1, weights=None):
    """Return the state of a reflex at the start."""
    genes = np.zeros((population, reflex.weights(LEGS))) if weights is None else weights
    return reflex.start(LEGS, genes)


def step(reflex, seen, state=None):
    """Return the inputs after one step."""
    inputs = inputs_of(seen)
    reflex.step(start(reflex, len(seen.phase)) if state is None else state, seen, inputs, INTERVAL)
    return inputs
