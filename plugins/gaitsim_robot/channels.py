"""The recorded channels of a robot."""

from collections.abc import Mapping

from gaitsim.contracts import Channel

XYZ = ("x", "y", "z")

CHANNELS: Mapping[str, Channel] = {
    "joint_angles": Channel(
        ("frames", "joints"), "rad", "commands to the servos, relative to the file's zero"
    ),
    "joint_positions": Channel(("frames", "joints"), "rad", "actual angles of the joints"),
    "joint_velocities": Channel(("frames", "joints"), "rad/s", "velocities of the joints"),
    "torque": Channel(
        ("frames", "joints"), "N m", "mean magnitude of the torque since the previous frame"
    ),
    "stall_torque": Channel(("joints",), "N m", "largest torque of the servos; 0 if unknown"),
    "torso": Channel(
        ("frames", XYZ), "m", "origin of the trunk, relative to the ground below its start"
    ),
    "torso_velocity": Channel(("frames", XYZ), "m/s", "velocity of the trunk's origin"),
    "orientation": Channel(
        ("frames", ("roll", "pitch", "yaw")),
        "rad",
        "roll to the right, pitch nose down, yaw to the left",
    ),
    "height": Channel(("frames",), "m", "height of the trunk's origin above the ground"),
    "foot_positions": Channel(
        ("frames", "feet", XYZ), "m", "points of the feet that touch the ground when standing"
    ),
    "stance": Channel(
        ("frames", "feet"), "", "whether the foot carried load since the previous frame"
    ),
    "load": Channel(
        ("frames", "feet", XYZ),
        "N",
        "mean force of the ground on each foot since the previous frame",
    ),
    "slip": Channel(("frames",), "m", "mean slide of the stance feet since the previous frame"),
    "energy": Channel(
        ("frames",), "J", "work of the servos since the start; braking counts as positive"
    ),
    "lasted": Channel((), "s", "time until the fall, or the length of the rollout"),
    "weight": Channel((), "N", "weight of the whole robot"),
    "length": Channel((), "m", "length of the trunk"),
    "configuration": Channel(
        ("frames", "coordinates"),
        "",
        "position and quaternion of the trunk, then the angles of all joints, m and rad",
    ),
}
