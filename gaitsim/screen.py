"""Screens of the terminal UI: their base, their keys and their widgets."""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
