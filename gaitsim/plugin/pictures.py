"""Scenes, videos, plots and pictures in the terminal."""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
