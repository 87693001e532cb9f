"""Parts shared by legged bodies: damage, conditions, commands, servos and measures of stepping."""

from gaitsim.choices import DAMAGE_HELP as DAMAGE_HELP
from gaitsim.legged.conditions import (
    CONDITIONS as CONDITIONS,
    condition_rng as condition_rng,
    conditions as conditions,
    draw_joint_errors as draw_joint_errors,
    draw_push as draw_push,
    world_seed as world_seed,
)
from gaitsim.legged.damage import Damage as Damage, Kind as Kind, parse_damage as parse_damage
from gaitsim.legged.sensors import (
    FEET_AND_JOINTS as FEET_AND_JOINTS,
    IMUS as IMUS,
    Imu as Imu,
    check_sensors as check_sensors,
    observed as observed,
)
from gaitsim.legged.servos import (
    SERVOS as SERVOS,
    Servo as Servo,
    commands_at as commands_at,
    delay_angles as delay_angles,
    hold_commands as hold_commands,
)
from gaitsim.legged.slopes import downward as downward, place_on_slope as place_on_slope
from gaitsim.legged.stepping import (
    BODY_HEIGHT as BODY_HEIGHT,
    STRIDE_FREQUENCY as STRIDE_FREQUENCY,
    STRIDE_FREQUENCY_CHANNEL as STRIDE_FREQUENCY_CHANNEL,
    angles_frequency as angles_frequency,
    stepping_measures as stepping_measures,
)
