"""The fly's presets."""
