"""Gait files: joint angles to and from MATLAB, CSV and NumPy."""
