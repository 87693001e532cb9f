"""Legged robots from URDF or MJCF files in rigid-body physics."""
