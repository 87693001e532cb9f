"""Gait analysis: footfalls, phases, support, travel, and the name of the gait."""

from gaitsim.gait.of_individual import analyse_individual, margin_of
from gaitsim.gait.quantities import quantities
from gaitsim.gait.report import Footfalls, GaitAnalysis, analyse_gait
from gaitsim.gait.support import stability_margin

__all__ = [
    "Footfalls",
    "GaitAnalysis",
    "analyse_gait",
    "analyse_individual",
    "margin_of",
    "quantities",
    "stability_margin",
]
