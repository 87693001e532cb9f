"""A second physics engine for robots: PyBullet, based on the model compiled by MuJoCo.

Masses, frames, shapes, servos, commands and the criteria of a fall are the same. Contacts differ:
Bullet's are hard, MuJoCo's are soft. Bullet needs shorter steps, as it integrates servos
explicitly.

Source: E. Coumans, Y. Bai, PyBullet, a Python module for physics simulation (2016–2021).
"""

from gaitsim_bullet.rollout import feel_out, roll_out

LIBRARY = "pybullet"
"""The library whose version affects results."""

__all__ = ["LIBRARY", "feel_out", "roll_out"]
