"""Adapt the gait of a damaged body in a few trials, guided by the map of an atlas."""

from gaitsim.adaptation.prior import Prior, read_prior
from gaitsim.adaptation.settings import Settings
from gaitsim.adaptation.trials import Proposal, Trial, adapt, best_of, ending, propose

__all__ = [
    "Prior",
    "Proposal",
    "Settings",
    "Trial",
    "adapt",
    "best_of",
    "ending",
    "propose",
    "read_prior",
]
