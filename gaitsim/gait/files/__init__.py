"""Gait files: joint angles to and from MATLAB, CSV, NumPy and servo keyframes."""
