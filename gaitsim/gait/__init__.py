"""Which gait a body walks: footfalls, phases, support, travel, and the gait's name."""

from gaitsim.gait.report import Footfalls, GaitAnalysis, analyse_gait
from gaitsim.gait.support import stability_margin

__all__ = ["Footfalls", "GaitAnalysis", "analyse_gait", "stability_margin"]
