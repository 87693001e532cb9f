"""Commands: their options and their output."""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
