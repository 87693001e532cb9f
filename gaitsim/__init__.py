"""Evolve gaits in your terminal."""
