"""Gait analysis: footfalls, phases, support, travel, and the name of the gait."""

from gaitsim.gait.changed import changed, with_world
from gaitsim.gait.damaged import can_be_damaged, damaged, with_damage
from gaitsim.gait.judgement import Judgement
from gaitsim.gait.of_individual import analyse_individual, margin_of
from gaitsim.gait.quantities import quantities
from gaitsim.gait.report import Footfalls, GaitAnalysis, analyse_gait
from gaitsim.gait.support import stability_margin
from gaitsim.gait.twin import on_twin, transferred
from gaitsim.gait.unseen import judge

__all__ = [
    "Footfalls",
    "GaitAnalysis",
    "Judgement",
    "analyse_gait",
    "analyse_individual",
    "can_be_damaged",
    "changed",
    "damaged",
    "judge",
    "margin_of",
    "on_twin",
    "quantities",
    "stability_margin",
    "transferred",
    "with_damage",
    "with_world",
]
