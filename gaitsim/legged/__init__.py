"""Parts shared by legged bodies: damage, conditions, commands, servos and measures of stepping."""

from gaitsim.choices import DAMAGE_HELP
from gaitsim.legged.conditions import (
    CONDITIONS,
    condition_rng,
    conditions,
    draw_joint_errors,
    draw_push,
    world_seed,
)
from gaitsim.legged.damage import Damage, Kind, parse_damage
from gaitsim.legged.sensors import FEET_AND_JOINTS, IMUS, Imu, check_sensors, observed
from gaitsim.legged.servos import SERVOS, Servo, commands_at, delay_angles, hold_commands
from gaitsim.legged.slopes import downward, place_on_slope
from gaitsim.legged.stepping import (
    BODY_HEIGHT,
    STRIDE_FREQUENCY,
    STRIDE_FREQUENCY_CHANNEL,
    angles_frequency,
    stepping_measures,
)

__all__ = [
    "BODY_HEIGHT",
    "CONDITIONS",
    "DAMAGE_HELP",
    "FEET_AND_JOINTS",
    "IMUS",
    "SERVOS",
    "STRIDE_FREQUENCY",
    "STRIDE_FREQUENCY_CHANNEL",
    "Damage",
    "Imu",
    "Kind",
    "Servo",
    "angles_frequency",
    "check_sensors",
    "commands_at",
    "condition_rng",
    "conditions",
    "delay_angles",
    "downward",
    "draw_joint_errors",
    "draw_push",
    "hold_commands",
    "observed",
    "parse_damage",
    "place_on_slope",
    "stepping_measures",
    "world_seed",
]
