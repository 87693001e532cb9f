"""Plots for papers and screens: one file for each kind, one style for all."""

from gaitsim.render.plots.fitness import fitness_figure
from gaitsim.render.plots.style import (
    COLOURS,
    DARK,
    FORMATS,
    LIGHT,
    STYLES,
    THEMES,
    Theme,
    check_target,
    picture,
    save,
    styled,
)

__all__ = [
    "COLOURS",
    "DARK",
    "FORMATS",
    "LIGHT",
    "STYLES",
    "THEMES",
    "Theme",
    "check_target",
    "fitness_figure",
    "picture",
    "save",
    "styled",
]
