"""Gait analysis: footfalls, phases, support, travel, and the name of the gait."""

from gaitsim.gait.changed import (
    can_be_damaged,
    compare_bodies,
    damage_body,
    play_on_twin,
    with_changed_body,
    with_damage,
    with_world,
)
from gaitsim.gait.report import (
    Footfalls,
    GaitAnalysis,
    analyse_gait,
    analyse_individual,
    margin_of,
    quantities,
)
from gaitsim.gait.travel import stability_margin
from gaitsim.gait.worlds import (
    CheckResults,
    FeedbackResults,
    UnseenResults,
    check_gait,
    compare_blind,
    evaluate_unseen,
)

__all__ = [
    "CheckResults",
    "FeedbackResults",
    "Footfalls",
    "GaitAnalysis",
    "UnseenResults",
    "analyse_gait",
    "analyse_individual",
    "can_be_damaged",
    "check_gait",
    "compare_blind",
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
