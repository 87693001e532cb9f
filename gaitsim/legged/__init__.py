"""What legged bodies share: damage to legs and joints, measures of how legs step, and servos."""

from gaitsim.legged.damage import DAMAGE_HELP, Damage, Kind, parse_damage
from gaitsim.legged.servos import SERVOS, Servo
from gaitsim.legged.stepping import BODY_HEIGHT, stepping

__all__ = [
    "BODY_HEIGHT",
    "DAMAGE_HELP",
    "SERVOS",
    "Damage",
    "Kind",
    "Servo",
    "parse_damage",
    "stepping",
]
