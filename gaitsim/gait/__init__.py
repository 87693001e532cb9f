"""Gait analysis: footfalls, phases, support, travel, and the name of the gait."""

from gaitsim.gait.changed import with_changed_body, with_world
from gaitsim.gait.damaged import can_be_damaged, damage_body, with_damage
from gaitsim.gait.individual_analysis import analyse_individual, margin_of
from gaitsim.gait.quantities import quantities
from gaitsim.gait.report import Footfalls, GaitAnalysis, analyse_gait
from gaitsim.gait.support import stability_margin
from gaitsim.gait.twin import compare_bodies, play_on_twin
from gaitsim.gait.unseen import evaluate_unseen
from gaitsim.gait.unseen_results import UnseenResults

__all__ = [
    "Footfalls",
    "GaitAnalysis",
    "UnseenResults",
    "analyse_gait",
    "analyse_individual",
    "can_be_damaged",
    "compare_bodies",
    "damage_body",
    "evaluate_unseen",
    "margin_of",
    "play_on_twin",
    "quantities",
    "stability_margin",
    "with_changed_body",
    "with_damage",
    "with_world",
]
