"""What is recorded of a robot."""

from collections.abc import Mapping

from gaitsim.contracts import Channel

XYZ = ("x", "y", "z")

CHANNELS: Mapping[str, Channel] = {
    "joint_angles": Channel(
        ("frames", "joints"), "rad", "commanded to the servos, from the zero of the file"
    ),
    "joint_positions": Channel(("frames", "joints"), "rad", "where the joints really are"),
    "joint_velocities": Channel(("frames", "joints"), "rad/s", "of the joints"),
    "torque": Channel(("frames", "joints"), "N m", "mean of its magnitude since the frame before"),
    "stall_torque": Channel(
        ("joints",), "N m", "largest torque of the servos; 0 where it is unknown"
    ),
    "torso": Channel(
        ("frames", XYZ), "m", "origin of the trunk, from above the point where it began"
    ),
    "torso_velocity": Channel(("frames", XYZ), "m/s", "of the origin of the trunk"),
    "orientation": Channel(
        ("frames", ("roll", "pitch", "yaw")), "rad", "to the right, nose down, to the left"
    ),
    "height": Channel(("frames",), "m", "origin of the trunk above the ground"),
    "foot_positions": Channel(
        ("frames", "feet", XYZ), "m", "points of the feet that touch the ground in standing"
    ),
    "stance": Channel(("frames", "feet"), "", "whether the foot bore load since the frame before"),
    "load": Channel(
        ("frames", "feet", XYZ),
        "N",
        "mean force of the ground on each foot since the frame before",
    ),
    "slip": Channel(("frames",), "m", "mean slide of the stance feet since the frame before"),
    "energy": Channel(
        ("frames",), "J", "work of the servos since the start, braking counted as spent"
    ),
    "lasted": Channel((), "s", "time before the fall, or the whole rollout"),
    "weight": Channel((), "N", "of the whole robot"),
    "length": Channel((), "m", "of the trunk"),
    "configuration": Channel(
        ("frames", "coordinates"),
        "",
        "position and quaternion of the trunk, then the angles of all joints, m and rad",
    ),
}
