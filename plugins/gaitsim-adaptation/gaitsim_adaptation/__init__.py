"""Adapt the gait of a damaged body in a few trials, guided by the map of an atlas."""
