"""Presets with creatures."""
