"""Parts of bodies and operators: portable arithmetic, encodings, networks, what legs share."""

from gaitsim.encoding import amplitude_limit as amplitude_limit
from gaitsim.encoding import check_joint_angles as check_joint_angles
from gaitsim.encoding import check_time_step as check_time_step
from gaitsim.encoding import GeneGroup as GeneGroup
from gaitsim.encoding import genome_space as genome_space
from gaitsim.encoding import limit_steps as limit_steps
from gaitsim.encoding import Oscillators as Oscillators
from gaitsim.encoding import split_genomes as split_genomes
from gaitsim.gaussian_process import matern as matern
from gaitsim.gaussian_process import posterior as posterior
from gaitsim.gaussian_process import Prediction as Prediction
from gaitsim.legged import angles_frequency as angles_frequency
from gaitsim.legged import BODY_HEIGHT as BODY_HEIGHT
from gaitsim.legged import check_sensors as check_sensors
from gaitsim.legged import commands_at as commands_at
from gaitsim.legged import condition_rng as condition_rng
from gaitsim.legged import CONDITIONS as CONDITIONS
from gaitsim.legged import conditions as conditions
from gaitsim.legged import Damage as Damage
from gaitsim.legged import DAMAGE_HELP as DAMAGE_HELP
from gaitsim.legged import delay_angles as delay_angles
from gaitsim.legged import downward as downward
from gaitsim.legged import draw_joint_errors as draw_joint_errors
from gaitsim.legged import draw_push as draw_push
from gaitsim.legged import FEET_AND_JOINTS as FEET_AND_JOINTS
from gaitsim.legged import hold_commands as hold_commands
from gaitsim.legged import Imu as Imu
from gaitsim.legged import IMUS as IMUS
from gaitsim.legged import Kind as Kind
from gaitsim.legged import observed as observed
from gaitsim.legged import parse_damage as parse_damage
from gaitsim.legged import place_on_slope as place_on_slope
from gaitsim.legged import Servo as Servo
from gaitsim.legged import SERVOS as SERVOS
from gaitsim.legged import stepping_measures as stepping_measures
from gaitsim.legged import STRIDE_FREQUENCY as STRIDE_FREQUENCY
from gaitsim.legged import STRIDE_FREQUENCY_CHANNEL as STRIDE_FREQUENCY_CHANNEL
from gaitsim.legged import world_seed as world_seed
from gaitsim.legged.damage import damage_options as damage_options
from gaitsim.network import ACTIVATION_CODES as ACTIVATION_CODES
from gaitsim.network import activation_slope as activation_slope
from gaitsim.network import activation_with as activation_with
from gaitsim.network import gene_count as gene_count
from gaitsim.network import gene_labels as gene_labels
from gaitsim.network import LEAKY_RELU as LEAKY_RELU
from gaitsim.network import Network as Network
from gaitsim.network import RELU as RELU
from gaitsim.network import SIGMOID as SIGMOID
from gaitsim.network import TANH as TANH
from gaitsim.portable import arccos as arccos
from gaitsim.portable import arcsin as arcsin
from gaitsim.portable import arctan as arctan
from gaitsim.portable import arctan2 as arctan2
from gaitsim.portable import binomial as binomial
from gaitsim.portable import cholesky as cholesky
from gaitsim.portable import compiled as compiled
from gaitsim.portable import cos as cos
from gaitsim.portable import distances as distances
from gaitsim.portable import exp as exp
from gaitsim.portable import log as log
from gaitsim.portable import matmul as matmul
from gaitsim.portable import norm as norm
from gaitsim.portable import power as power
from gaitsim.portable import principal_axes as principal_axes
from gaitsim.portable import scalar as scalar
from gaitsim.portable import sin as sin
from gaitsim.portable import solve as solve
from gaitsim.portable import solve_triangular as solve_triangular
from gaitsim.portable import standard_normal as standard_normal
from gaitsim.portable import tan as tan
from gaitsim.portable import uniform as uniform
from gaitsim.portable.compiled import sin_and_cos as compiled_sin_and_cos
from gaitsim.portable.compiled import tanh as compiled_tanh
from gaitsim.portable.normal import fill as normal_fill
from gaitsim.portable.normal import strips as normal_strips
from gaitsim.portable.scalar import cos as scalar_cos
from gaitsim.portable.scalar import sin as scalar_sin
from gaitsim.portable.scalar import tan as scalar_tan

__all__ = [
    "ACTIVATION_CODES",
    "activation_slope",
    "activation_with",
    "amplitude_limit",
    "angles_frequency",
    "arccos",
    "arcsin",
    "arctan",
    "arctan2",
    "binomial",
    "BODY_HEIGHT",
    "check_joint_angles",
    "check_sensors",
    "check_time_step",
    "cholesky",
    "commands_at",
    "compiled",
    "compiled_sin_and_cos",
    "compiled_tanh",
    "condition_rng",
    "CONDITIONS",
    "conditions",
    "cos",
    "Damage",
    "DAMAGE_HELP",
    "damage_options",
    "delay_angles",
    "distances",
    "downward",
    "draw_joint_errors",
    "draw_push",
    "exp",
    "FEET_AND_JOINTS",
    "gene_count",
    "gene_labels",
    "GeneGroup",
    "genome_space",
    "hold_commands",
    "Imu",
    "IMUS",
    "Kind",
    "LEAKY_RELU",
    "limit_steps",
    "log",
    "matern",
    "matmul",
    "Network",
    "norm",
    "normal_fill",
    "normal_strips",
    "observed",
    "Oscillators",
    "parse_damage",
    "place_on_slope",
    "posterior",
    "power",
    "Prediction",
    "principal_axes",
    "RELU",
    "scalar",
    "scalar_cos",
    "scalar_sin",
    "scalar_tan",
    "Servo",
    "SERVOS",
    "SIGMOID",
    "sin",
    "solve",
    "solve_triangular",
    "split_genomes",
    "standard_normal",
    "stepping_measures",
    "STRIDE_FREQUENCY",
    "STRIDE_FREQUENCY_CHANNEL",
    "tan",
    "TANH",
    "uniform",
    "world_seed",
]
