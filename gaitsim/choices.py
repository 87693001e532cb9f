"""Allowed values of options that several modules share.

This module imports nothing heavy, so that `--help` stays fast.
"""

from typing import Literal

GaitFormat = Literal["mat", "csv", "npz"]
PlotFormat = Literal["png", "svg", "pdf"]
VideoFormat = Literal["mp4", "gif"]

ComparisonPlot = Literal["convergence", "ecdf"]
Theme = Literal["light", "dark"]
VideoView = Literal["iso", "side", "top", "orbit"]
TerminalView = Literal["iso", "side", "top", "front"]

Quantity = Literal["best", "mean", "median", "diversity"]
Axis = Literal["generation", "evaluations", "seconds"]

Activation = Literal["leaky-relu", "relu", "tanh", "sigmoid"]
OutputActivation = Literal["linear", "same"]
TrainingPreset = Literal["source", "steady"]

STEERING_KEYS = ("up", "down", "left", "right", "space", "a", "d", "w", "s", "x")
"""Keys that a command of a steered body may use; the steering screen does not use the letters."""

DAMAGE_HELP = (
    "damage to legs and joints, such as 'L2 lost', 'R1 femur stuck 20' (at 20°), "
    "'R1 femur weak 0.5' (half its torque) or 'R1 femur slow 0.5' (half its speed)"
)
