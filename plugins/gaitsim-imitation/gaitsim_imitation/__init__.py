"""Train networks that imitate a gait by predicting each frame from the previous one."""

from gaitsim_imitation.imitator import load_imitator

__all__ = ["load_imitator"]
