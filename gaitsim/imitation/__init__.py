"""Train a network to imitate a gait: it predicts each frame from the one before."""

from gaitsim.imitation.file import load_imitator

__all__ = ["load_imitator"]
