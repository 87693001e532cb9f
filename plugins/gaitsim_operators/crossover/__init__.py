"""Crossover operators, which combine pairs of parents into children."""
