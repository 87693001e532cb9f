"""Any legged robot, from a URDF or MJCF file, in rigid-body physics."""
