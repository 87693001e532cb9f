"""What legged bodies share: damage to legs and joints, and measures of how legs step."""

from gaitsim.legged.damage import DAMAGE_HELP, Damage, Kind, parse_damage
from gaitsim.legged.stepping import BODY_HEIGHT, stepping

__all__ = ["BODY_HEIGHT", "DAMAGE_HELP", "Damage", "Kind", "parse_damage", "stepping"]
