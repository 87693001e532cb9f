"""Presets with robots."""
