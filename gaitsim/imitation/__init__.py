"""Train a network to imitate a gait: it predicts each frame from the one before."""

from gaitsim.imitation.file import Imitation, load_imitator, save_imitator
from gaitsim.imitation.imitator import Imitator
from gaitsim.imitation.learning import SETTINGS, Settings, learn

__all__ = [
    "SETTINGS",
    "Imitation",
    "Imitator",
    "Settings",
    "learn",
    "load_imitator",
    "save_imitator",
]
