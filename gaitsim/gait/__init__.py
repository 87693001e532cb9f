"""Gait analysis: footfalls, phases, support, travel, and the name of the gait."""

from gaitsim.gait.report import Footfalls, GaitAnalysis, analyse_gait
from gaitsim.gait.support import stability_margin

__all__ = ["Footfalls", "GaitAnalysis", "analyse_gait", "stability_margin"]
