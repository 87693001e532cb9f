"""Creatures: trees of buildable modules that evolve together with their gaits."""
