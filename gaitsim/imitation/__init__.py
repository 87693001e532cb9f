"""A network learns a gait: from each frame to the next; then it plays on its own."""

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
