"""Crossover: children from pairs of parents."""
