"""A second physics engine for robots: PyBullet, from the model that MuJoCo compiled.

Masses, frames, shapes, servos, commands and the rules of a fall are the same. Contacts are not:
Bullet's are hard, MuJoCo's soft. Bullet takes shorter steps, in which servos are explicit.

Source: E. Coumans, Y. Bai, PyBullet, a Python module for physics simulation (2016–2021).
"""

from gaitsim_robot.bullet.rollout import roll_out

__all__ = ["roll_out"]
