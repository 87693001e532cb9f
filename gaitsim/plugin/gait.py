"""Analysis of gaits, gait files, and gaits on changed bodies."""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
