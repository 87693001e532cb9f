"""Parts shared by legged bodies: damage, conditions, commands, servos and measures of stepping."""

from gaitsim.legged.commands import delayed, held, in_force
from gaitsim.legged.conditions import (
    CONDITIONS,
    conditions,
    drawn_push,
    joint_errors,
    seed_of,
    stream,
)
from gaitsim.legged.damage import DAMAGE_HELP, Damage, Kind, parse_damage
from gaitsim.legged.servos import SERVOS, Servo
from gaitsim.legged.stepping import BODY_HEIGHT, stepping

__all__ = [
    "BODY_HEIGHT",
    "CONDITIONS",
    "DAMAGE_HELP",
    "SERVOS",
    "Damage",
    "Kind",
    "Servo",
    "conditions",
    "delayed",
    "drawn_push",
    "held",
    "in_force",
    "joint_errors",
    "parse_damage",
    "seed_of",
    "stepping",
    "stream",
]
