"""The presets of robots."""
