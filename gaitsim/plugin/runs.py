"""Experiments, evaluation, runs and their individuals."""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
