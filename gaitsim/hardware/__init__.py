"""Gaits for real robots: calibrations, servo tables, Arduino sketches and ROS 2 messages."""
